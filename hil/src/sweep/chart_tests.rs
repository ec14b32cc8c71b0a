//! Span of an axis, and values under the pointer.

use super::*;

fn line(name: &str, spots: &[(f64, f64)]) -> Line {
    let spots = spots.iter().filter_map(|&(x, y)| Spot::around(x, &[y]));
    Line {
        name: name.into(),
        spots: spots.collect(),
    }
}

#[test]
fn an_axis_shows_noise_as_noise() {
    // A hundredth of a percent between runs is no step.
    let (low, high) = wide_enough(Some((61.126, 61.149)), "%");
    assert!(
        high - low >= 6.0 && low < 61.0 && high > 61.2,
        "{low} {high}"
    );
    // What differs keeps its own ends.
    assert_eq!(wide_enough(Some((0.1, 0.4)), "mm"), (0.1, 0.4));
    let (low, high) = wide_enough(Some((-0.1, 0.1)), "dB");
    assert!((high - low - 1.0).abs() < 1e-12 && low < 0.0);
    // Breaks are never negative.
    assert!(wide_enough(Some((0.0, 0.01)), "mm").0.abs() < 1e-12);
    assert_eq!(wide_enough(None, ""), (0.0, 1.0));
    for odd in [f64::NAN, f64::INFINITY, 1e300] {
        let page = chart(
            &[line("a", &[(odd, 1.0), (1.0, odd)])],
            ("x", ""),
            ("y", "mm"),
        );
        assert!(page.starts_with("<figure") && page.ends_with("</figure>\n"));
    }
}

#[test]
fn a_chart_has_its_values_for_the_pointer() {
    let mut spread = line("<b>", &[(100.0, 1.25)]);
    spread.spots[0].low = 1.0;
    let lines = [spread, line("", &[(100.0, 2.0), (130.0, 3.5)])];
    let page = chart(&lines, ("soa", "ms"), ("felt", "mm"));
    for words in [
        "soa 100 ms",
        "soa 130 ms",
        "&lt;b&gt;: 1.25 mm (1 to 1.25)",
        "[1,&quot;3.5 mm&quot;]",
    ] {
        assert!(page.contains(words), "{words}: {page}");
    }
    assert!(!page.contains("<b>"));
}
