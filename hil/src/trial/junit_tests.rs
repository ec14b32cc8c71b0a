//! Tests of `junit.rs`.

use super::*;
use std::time::Duration;

#[test]
fn every_verdict_has_its_element_and_text_is_escaped() {
    let trial = |scene: &str, verdict| Trial {
        verdict,
        took: Duration::from_millis(1500),
        ..Trial::skipped(scene, String::new())
    };
    let text = junit(
        "a<b>",
        &[
            trial("one", Verdict::Passed),
            trial("two", Verdict::Unstable(vec!["a \"b\" & c".to_owned()])),
            trial("three", Verdict::Failed(vec!["x".into(), "y".into()])),
            trial(
                "four",
                Verdict::Quarantined(vec!["x".into()], "known".into()),
            ),
            trial("five", Verdict::Skipped("bench lacks touch".to_owned())),
        ],
    );
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
