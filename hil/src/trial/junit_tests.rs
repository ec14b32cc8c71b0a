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
        ..Trial::skipped(scene, String::new())
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
    ];
    let text = junit(&[("a<b>".to_owned(), trials)]);
    assert!(text.contains("tests=\"5\" failures=\"1\" errors=\"0\" skipped=\"2\" time=\"7.500\""));
    assert!(text.contains("classname=\"a&lt;b&gt;\" name=\"one\" time=\"1.500\""));
    assert!(text.contains("<flakyFailure message=\"a &quot;b&quot; &amp; c\"/>"));
    assert!(text.contains("<failure message=\"x; y\"/>"));
    assert!(text.contains("<skipped message=\"quarantined: known; failed: x\"/>"));
    assert!(text.contains("<skipped message=\"bench lacks touch\"/>"));
    assert_eq!(
        text.matches("<testcase").count(),
        text.matches("</testcase>").count()
    );
}
