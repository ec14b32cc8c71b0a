//! Tests of `scale.rs`.

use super::*;

#[test]
fn ticks_are_round_and_few() {
    let texts: Vec<_> = Scale::round(0.3, 9.7)
        .ticks(5.0)
        .into_iter()
        .map(|t| t.1)
        .collect();
    assert_eq!(texts, ["0", "2", "4", "6", "8", "10"]);
    let texts: Vec<_> = Scale::decades(0.6, 10_000.0)
        .ticks(8.0)
        .into_iter()
        .map(|t| t.1)
        .collect();
    assert_eq!(texts.first().map(String::as_str), Some("0.10"));
    let texts: Vec<_> = Scale::decades(2e-12, 1e-9)
        .ticks(8.0)
        .into_iter()
        .map(|t| t.1)
        .collect();
    assert_eq!(
        texts,
        [
            "10\u{207b}\u{b9}\u{b2}",
            "10\u{207b}\u{b9}\u{b9}",
            "10\u{207b}\u{b9}\u{2070}",
            "10\u{207b}\u{2079}"
        ]
    );
    assert!(Scale::exact(f64::NAN, 3.0).ticks(5.0).len() > 2);
    let counts = Scale::exact(0.5, 2.5).of_counts(true).ticks(5.0);
    assert_eq!(counts, [(1.0, "1".to_owned()), (2.0, "2".to_owned())]);
    assert!(Scale::round(5.0, 5.0).ticks(5.0).len() > 2);
}

#[test]
fn a_logarithmic_axis_has_ticks_within_its_decades() {
    let ticks = |low, high| -> Vec<String> {
        let scale = Scale::logarithmic(low, high);
        scale.ticks(5.0).into_iter().map(|tick| tick.1).collect()
    };
    assert_eq!(ticks(10.0, 300.0), ["10", "20", "50", "100", "200"]);
    assert_eq!(ticks(0.04, 3.0), ["0.05", "0.1", "0.2", "0.5", "1", "2"]);
    let scale = Scale::logarithmic(10.0, 300.0);
    assert!(scale.at(10.0).abs() < 1e-12 && (scale.at(300.0) - 1.0).abs() < 1e-12);
    for bad in [f64::NAN, 0.0, -1.0, f64::INFINITY] {
        let scale = Scale::logarithmic(bad, bad);
        assert!(scale.ticks(5.0).len() < 100, "{bad}");
    }
}
