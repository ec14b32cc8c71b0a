//! What a person may answer.

use super::*;

#[test]
fn answers_are_letters_or_words_and_a_reason_follows() {
    assert_eq!(Answer::parse(" a "), Answer::Accept(None));
    assert_eq!(
        Answer::parse("accept one period longer"),
        Answer::Accept(Some("one period longer".to_owned()))
    );
    assert_eq!(Answer::parse("r"), Answer::Reject);
    assert_eq!(Answer::parse("reject that"), Answer::Unclear);
    assert_eq!(Answer::parse(""), Answer::Unclear);
}
