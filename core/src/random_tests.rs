//! Tests of `random.rs`.

use super::*;

#[test]
fn streams_are_reproducible_and_independent() {
    let draw = |seed, id: &str| RandomStream::new(seed, id).next_u64();
    assert_eq!(draw(1, "taxel 3"), draw(1, "taxel 3"));
    assert_ne!(draw(1, "taxel 3"), draw(1, "taxel 4"));
    assert_ne!(draw(1, "taxel 3"), draw(2, "taxel 3"));
}

#[test]
fn a_copy_goes_on_where_the_original_stands() {
    let mut stream = RandomStream::new(3, "copied");
    for drawn in 0..40 {
        let mut copy = stream.clone();
        let ahead: [u64; 20] = core::array::from_fn(|_| copy.next_u64());
        let mut original = stream.clone();
        assert_eq!(
            ahead,
            core::array::from_fn(|_| original.next_u64()),
            "{drawn}"
        );
        let first = stream.next_u64();
        assert_eq!(ahead[0], first, "{drawn}");
    }
}

#[test]
fn normal_deviates_have_unit_variance() {
    let mut stream = RandomStream::new(7, "test");
    let n = 20_000;
    let (mut sum, mut sum2) = (0.0, 0.0);
    for _ in 0..n {
        let x = stream.normal();
        assert!(x.is_finite());
        sum += x;
        sum2 += x * x;
    }
    let mean = sum / f64::from(n);
    assert!(mean.abs() < 0.03, "{mean}");
    assert!((sum2 / f64::from(n) - 1.0).abs() < 0.05);
}
