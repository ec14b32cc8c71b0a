//! Which figures of two objects differ.

use super::*;
use palpate_records::verdict::Verdict;
use serde_json::json;

#[test]
fn figures_are_found_by_name_and_timings_are_none() {
    let a = json!({"wall_s": 1.0, "e": {"rmse": 2.0, "why": ["x"]}, "m": [{"name": "p", "w": 1}, {"name": "q", "w": 2}], "n": null});
    let b = json!({"wall_s": 9.0, "e": {"rmse": 2.1, "why": ["x"]}, "m": [{"name": "q", "w": 3}, {"name": "p", "w": 1}], "n": null});
    let found = compare_objects(&a, &b, Tolerance::default());
    let words: Vec<String> = found
        .differences
        .iter()
        .map(|d| d.words().split_whitespace().collect::<Vec<_>>().join(" "))
        .collect();
    assert_eq!(
        words,
        ["e.rmse 2 -> 2.1 (+5.00 %)", "m[q].w 2 -> 3 (+50.00 %)"]
    );
    assert_eq!(
        (found.conclusion.verdict, found.figures),
        (Verdict::Failed, 7)
    );
    let found = compare_objects(&a, &b, Tolerance(0.06));
    assert_eq!(found.differences.len(), 1);
    assert_eq!(
        compare_objects(&a, &a, Tolerance::default())
            .conclusion
            .verdict,
        Verdict::Ok
    );
    assert_eq!(
        compare_objects(&json!({}), &json!({}), Tolerance::default())
            .conclusion
            .verdict,
        Verdict::Incomplete
    );
    let gone = compare_objects(
        &json!({"x": 1, "y": 0}),
        &json!({"y": 1}),
        Tolerance::default(),
    );
    let words: Vec<String> = gone.differences.iter().map(Difference::words).collect();
    assert!(
        words[0].ends_with("1 -> nothing") && words[1].ends_with("0 -> 1 (+1)"),
        "{words:?}"
    );
}

/// Decibels and degrees have no zero that a part of them could start from.
#[test]
fn levels_and_temperatures_are_told_by_their_difference() {
    let object = |level: f64, skin: f64, used: f64| {
        json!({
            "margins": [{"name": "skin", "worst": skin, "limit": 43.0, "unit": "C", "margin": 43.0 - skin, "used": used}],
            "felt": {"level_db": {"median": level}, "error_energy_mm": {"rmse": 1.0}},
            "felt_error_mm": {"rmse": 1.0, "breaks": 0},
            "hottest_skin_c": skin,
            "energy_mj": 100.0 + skin,
        })
    };
    let (a, b) = (object(-0.172, 34.0, 0.1), object(-0.082, 35.0, 0.2));
    let found = compare_objects(&a, &b, Tolerance::default());
    let words: Vec<String> = found.differences.iter().map(Difference::words).collect();
    let words = words.join("\n");
    for part in ["(+0.09 dB)", "(+1 \u{b0}C)", "(+1 C)", "(+0.75 %)"] {
        assert!(words.contains(part), "{part}: {words}");
    }
    assert!(
        !words.contains("margins[skin].used") && !words.contains("margins[skin].margin"),
        "{words}"
    );
    let named: Vec<(&str, String)> = found.named.iter().map(|n| (n.key, n.grown())).collect();
    assert_eq!(
        named,
        [
            ("felt_level_db", "+0.09 dB".to_owned()),
            ("felt_breaks", String::new()),
            ("felt_error_rmse_mm", String::new()),
            ("hottest_skin_c", "+1 \u{b0}C".to_owned()),
            ("limit_used_percent", "+10 points".to_owned()),
            ("energy_mj", "+0.75 %".to_owned()),
        ]
    );
    assert_eq!(
        found.conclusion.line(),
        "FAILED: 4 of 6 figures differ, first of all felt level over threshold -0.172 -> -0.082 dB"
    );
}

/// An earlier version wrote seventeen digits of a number with three.
#[test]
fn how_a_number_was_written_is_no_difference() {
    let (a, b) = (json!({"max": 1.531}), json!({"max": 1.5310000000000001}));
    let same = compare_objects(&a, &b, Tolerance::default());
    assert!(same.differences.is_empty(), "{:?}", same.differences);
}

#[test]
fn what_stands_twice_in_a_summary_is_told_once() {
    let object = |error: f64| {
        json!({
            "felt": {"error_energy_mm": {"rmse": error}, "breaks": 1},
            "felt_error_mm": {"rmse": error, "breaks": 1},
        })
    };
    let found = compare_objects(&object(1.0), &object(2.0), Tolerance::default());
    let figures: Vec<&str> = found.differences.iter().map(|d| &*d.figure).collect();
    assert_eq!(figures, ["felt_error_mm.rmse"]);
}
