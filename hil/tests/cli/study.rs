//! `hil study`.

use serde_json::Value;

use super::*;

#[test]
fn simulated_people_say_how_well_a_protocol_finds_their_thresholds() {
    let said = good(&[
        "study",
        "simulate",
        "thresholds",
        "--people",
        "40",
        "--json",
    ]);
    let found: Value = serde_json::from_str(&said).unwrap();
    assert_eq!(found["protocol"], "thresholds");
    assert_eq!(found["thresholds"], 320);
    let error = found["threshold_error_median"].as_f64().unwrap();
    let coverage = found["coverage"].as_f64().unwrap();
    assert!(error > 0.0 && error < 0.1, "{found}");
    assert!((0.88..=1.0).contains(&coverage), "{found}");
    assert!(found.get("false_positive_rate").is_none(), "{found}");
    assert!(
        found["assumed"].as_str().unwrap().contains("simulated"),
        "{found}"
    );
    let text = good(&["study", "simulate", "thresholds", "--people", "40"]);
    assert!(
        text.contains("median of 320 thresholds; 60 trials each"),
        "{text}"
    );
}

#[test]
fn and_how_many_people_a_difference_needs() {
    let said = good(&["study", "simulate", "roughness", "--json"]);
    let found: Value = serde_json::from_str(&said).unwrap();
    assert!(
        found["false_positive_rate"].as_f64().unwrap() <= 0.065,
        "{found}"
    );
    assert!(found["people_for_power"].as_u64().unwrap() > 8, "{found}");
}

#[test]
fn what_cannot_be_simulated_is_refused() {
    refused_with(
        &["study", "simulate", "roughness", "--people", "3"],
        &["--people", "expected 4 at least"],
    );
    refused_with(
        &["study", "simulate", "treshold"],
        &["did you mean `thresholds`"],
    );
}
