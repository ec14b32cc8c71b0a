//! Tests of `decays.rs`.

use super::*;

#[test]
fn the_last_four_stretches_are_at_hand() {
    let mut stretches = Stretches::new();
    let us = Duration::from_micros;
    for n in 1..=6 {
        assert_eq!(stretches.of(us(n)).span, us(n));
    }
    let mut spans = stretches.last.map(|s| s.span);
    spans.sort();
    assert_eq!(spans, [us(3), us(4), us(5), us(6)]);
    // asking again makes nothing anew
    stretches.of(us(3));
    stretches.of(us(7));
    assert!(stretches.last.iter().all(|s| s.span != us(3)));
}
