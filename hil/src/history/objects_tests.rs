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
        words[0].ends_with("1 -> nothing") && words[1].ends_with("0 -> 1"),
        "{words:?}"
    );
}
