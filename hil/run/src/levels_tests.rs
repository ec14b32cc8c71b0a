//! Tests of `levels.rs`.

use super::*;

#[test]
fn few_of_many_intensities_keep_the_ends_and_the_shape() {
    let many: Vec<f32> = (0..400_000u32)
        .map(|n| (n * 7919 % 400_000) as f32)
        .collect();
    let few = thinned(many.clone());
    assert_eq!(few.len(), TELLING);
    assert_eq!((few[0], few[TELLING - 1]), (0.0, 399_999.0));
    assert!((few[TELLING / 2] - 200_000.0).abs() < 4.0);
    assert_eq!(thinned(vec![2.0, 1.0]), [2.0, 1.0]);
}
