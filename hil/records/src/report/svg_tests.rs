//! Tests of `svg.rs`.

use super::*;

#[test]
fn an_envelope_keeps_extremes_and_breaks_at_nan() {
    let points = [
        (0.0, 1.0),
        (0.2, 9.0),
        (0.4, -5.0),
        (0.9, 2.0),
        (f64::NAN, 0.0),
        (3.0, 3.0),
    ];
    let path = envelope(points.into_iter());
    assert_eq!(path, "M0.0 1.0L0.2 9.0L0.4 -5.0L0.9 2.0M3.0 3.0");
    assert_eq!(escape("<a b='c'>&\u{7}"), "&lt;a b=&#39;c&#39;&gt;&amp; ");
}
