//! Tests of `decays.rs`.

use super::*;

#[test]
fn the_last_four_stretches_are_at_hand() {
    let mut stretches = Stretches::new();
    let us = Duration::from_micros;
    for n in 1..=6 {
        assert_eq!(stretches.stretch(us(n)).span, us(n));
    }
    let mut spans = stretches.last.map(|s| s.span);
    spans.sort();
    assert_eq!(spans, [us(3), us(4), us(5), us(6)]);
    // asking again makes nothing anew
    stretches.stretch(us(3));
    stretches.stretch(us(7));
    assert!(stretches.last.iter().all(|s| s.span != us(3)));
}

#[test]
fn a_stretch_leaves_what_each_rate_does() {
    for us in [1, 20_000, 250_000, 10_000_000] {
        let stretch = Stretch::new(Duration::from_micros(us));
        for (left, rate) in stretch.left.iter().zip(RATES) {
            let expected = libm::exp(-rate * stretch.seconds);
            assert!((left - expected).abs() < 1e-12, "{us}: {left} {expected}");
        }
    }
    assert!(RATES.is_sorted_by(|slower, faster| *faster == 2.0 * slower));
}
