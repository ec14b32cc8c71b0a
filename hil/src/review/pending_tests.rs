//! Tests of `pending.rs`.

use super::*;

#[test]
fn a_reason_stays_with_the_golden_and_the_line_does_not() {
    let text = "---\nsource: a.rs\nassertion_line: 31\n---\nbody\n---\nmore\n";
    assert_eq!(
        settled(text, None),
        "---\nsource: a.rs\n---\nbody\n---\nmore\n"
    );
    assert_eq!(
        settled(text, Some(" one \"period\"\nlonger ")),
        "---\nsource: a.rs\ndescription: \"one \\\"period\\\"\\nlonger\"\n---\nbody\n---\nmore\n"
    );
    let again = settled(&settled(text, Some("first")), Some("second"));
    assert!(again.contains("second") && !again.contains("first"));
    assert_eq!(settled("no heading", Some("x")), "no heading");
}
