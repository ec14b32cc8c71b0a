//! Tests of `near.rs`.

use super::*;

#[test]
fn a_slip_is_recognised_and_another_word_is_not() {
    let keys = ["length_s", "layout", "rate_hz", "kc", "ki"];
    for (word, meant) in [
        ("lenght_s", Some("length_s")),
        ("Length-s", Some("length_s")),
        ("layouts", Some("layout")),
        ("ratehz", Some("rate_hz")),
        ("rate", Some("rate_hz")),
        ("kx", None), // half of it differs
        ("colour", None),
        ("", None),
    ] {
        assert_eq!(nearest(word, keys), meant, "{word}");
    }
    assert_eq!(nearest("gone.toml", ["good.toml"]), None);
    assert_eq!(nearest("mine", ["nine.toml"]), Some("nine.toml"));
    assert_eq!(did_you_mean("lay_out", keys), "; did you mean `layout`?");
    assert_eq!(did_you_mean("colour", keys), "");
}

#[test]
fn words_in_backquotes() {
    let found: Vec<_> = quoted_words("one of the keys `a`, `b-c` or `d`").collect();
    assert_eq!(found, ["a", "b-c", "d"]);
    assert_eq!(quoted_words("no words").count(), 0);
}
