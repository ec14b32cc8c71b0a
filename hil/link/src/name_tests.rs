//! Tests of `name.rs`.

use super::*;

#[test]
fn a_finger_makes_its_keys() {
    let finger: FingerName = "r1/left/index".parse().unwrap();
    assert_eq!(finger.contacts(), "palpate/r1/left/index/contacts");
    assert_eq!(
        finger.echo(&"w-1".parse().unwrap()),
        "palpate/r1/left/index/echo/w-1"
    );
    assert_eq!(finger.skin_alive("*"), "palpate/r1/left/index/alive/skin/*");
}

#[test]
fn names_make_no_patterns_and_no_other_keys() {
    for wrong in [
        "",
        "*",
        "r1/left",
        "r1/left/index/x",
        "r1/**/index",
        "R1/left/index",
        "r1/le ft/index",
        "r1//index",
        "r1/$*/i",
    ] {
        assert!(wrong.parse::<FingerName>().is_err(), "{wrong}");
    }
    assert!("a".repeat(65).parse::<Name>().is_err() && "a".repeat(64).parse::<Name>().is_ok());
}
