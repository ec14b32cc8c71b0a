//! Tests of `rate.rs`.

use super::*;

#[test]
fn so_many_at_once_and_then_so_many_per_second() {
    let mut bucket = Bucket::new(1000, 10);
    let at = Instant::from_micros;
    let taken = (0..50).filter(|_| bucket.take(at(5))).count();
    assert_eq!(taken, 10);
    assert!(!bucket.take(at(1004)) && bucket.take(at(1005)) && !bucket.take(at(1005)));
    // A second of a flood, and time that goes back.
    let taken = (0..100_000_u64)
        .filter(|i| bucket.take(at(1005 + 10 * i)))
        .count();
    assert!((990..=1010).contains(&taken), "{taken}");
    assert!(!bucket.take(at(0)));
}
