//! What a person may answer.

use super::*;

#[test]
fn answers_are_letters_or_words_and_a_reason_follows() {
    assert_eq!(Answer::of(" a "), Answer::Accept(None));
    assert_eq!(
        Answer::of("accept one period longer"),
        Answer::Accept(Some("one period longer".to_owned()))
    );
    assert_eq!(Answer::of("r"), Answer::Reject);
    assert_eq!(Answer::of("reject that"), Answer::Unclear);
    assert_eq!(Answer::of(""), Answer::Unclear);
}
