//! Tests of `vector.rs`.

use super::*;
use alloc::vec::Vec;

#[test]
fn square_roots_are_the_same_in_every_width() {
    let values: Vec<f32> = (0..1_000_003u32)
        .map(|i| f32::from_bits(i.wrapping_mul(2139)))
        .collect();
    let (mut wide, mut plain) = (values.clone(), values.clone());
    Vectors::widest().sqrt(&mut wide);
    Vectors::plain().sqrt(&mut plain);
    let bits = |v: &[f32]| v.iter().map(|v| v.to_bits()).collect::<Vec<_>>();
    assert_eq!(bits(&wide), bits(&plain));
    assert!(
        values
            .iter()
            .zip(&wide)
            .all(|(v, root)| *root == libm::sqrtf(*v))
    );
}
