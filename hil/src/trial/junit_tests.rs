//! Tests of `junit.rs`.

use super::*;
use palpate_records::verdict::{Conclusion, Verdict};
use std::time::Duration;

fn failed(why: &[&str]) -> Conclusion {
    Conclusion {
        verdict: Verdict::Failed,
        why: why.iter().map(|w| (*w).to_owned()).collect(),
    }
}

#[test]
fn every_verdict_has_its_element_and_text_is_escaped() {
    let trial = |scene: &str, end| Trial {
        end,
        took: Duration::from_millis(1500),
        ..Trial::untried(scene, TrialEnd::Passed)
    };
    let trials = vec![
        trial("one", TrialEnd::Passed),
        trial("two", TrialEnd::Unstable(vec!["a \"b\" & c".to_owned()])),
        trial("three", TrialEnd::Failed(failed(&["x", "y"]))),
        trial(
            "four",
            TrialEnd::Quarantined(failed(&["x"]), "known".into()),
        ),
        trial("five", TrialEnd::Skipped("bench lacks touch".to_owned())),
        trial(
            "six",
            TrialEnd::Refused("the scene wants a unit".to_owned()),
        ),
        trial(
            "seven",
            TrialEnd::Noted(Conclusion {
                verdict: Verdict::NotFelt,
                why: vec!["3 of 9".to_owned()],
            }),
        ),
        trial("eight", TrialEnd::Broken("eight.toml: \u{FFFE}".to_owned())),
    ];
    let text = junit(&[("a<b>".to_owned(), trials)]);
    assert!(text.contains("tests=\"8\" failures=\"1\" errors=\"1\" skipped=\"3\" time=\"12.000\""));
    assert!(text.contains("classname=\"a&lt;b&gt;\" name=\"one\" time=\"1.500\""));
    assert!(text.contains("<flakyFailure message=\"a &quot;b&quot; &amp; c\"/>"));
    assert!(text.contains("<failure message=\"x; y\">x; y</failure>"));
    assert!(text.contains("<skipped message=\"quarantined: known; failed: x\"/>"));
    assert!(text.contains("<skipped message=\"bench lacks touch\"/>"));
    assert!(text.contains("<skipped message=\"refused: the scene wants a unit\"/>"));
    assert!(text.contains("<system-out>NOT FELT: 3 of 9</system-out>"));
    assert!(text.contains("<error message=\"eight.toml: \u{FFFD}\">eight.toml: \u{FFFD}</error>"));
    assert_eq!(
        text.matches("<testcase").count(),
        text.matches("</testcase>").count()
    );
}
