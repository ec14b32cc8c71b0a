//! Tests of `ranges.rs`.

use super::*;

#[test]
fn both_ends_of_a_range_count_and_its_decimals_are_exact() {
    let of = |text: &str| range(text).unwrap().unwrap().join(" ");
    assert_eq!(of("1..4"), "1 2 3 4");
    assert_eq!(of("7..7"), "7");
    assert_eq!(of("0.1..0.5:0.1"), "0.1 0.2 0.3 0.4 0.5");
    assert_eq!(of("100..130:12"), "100 112 124");
    assert_eq!(of("-1..1:0.5"), "-1 -0.5 0 0.5 1");
    assert_eq!(of("-0.25..0:0.25"), "-0.25 0");
    assert_eq!(
        of("18446744073709551614..18446744073709551615"),
        "18446744073709551614 18446744073709551615"
    );
}

#[test]
fn what_is_no_range_of_numbers_is_a_value() {
    for text in [
        "1",
        "a..b",
        "1..",
        "..2",
        "../mine.toml",
        "1..2:",
        "1e3..2e3",
        "1...2",
        "",
        "..",
        "nan..1",
        "999999999999999999999..1",
    ] {
        assert_eq!(range(text), Ok(None), "{text}");
    }
}

#[test]
fn a_range_without_values_or_with_too_many_is_refused() {
    assert!(range("5..1").unwrap_err().contains("1..5"));
    assert!(range("1..5:0").unwrap_err().contains("above 0"));
    assert!(range("1..5:-1").unwrap_err().contains("above 0"));
    assert!(range("1..1000001").unwrap_err().contains("1000000"));
    assert!(
        range("0..1:0.000000000001")
            .unwrap_err()
            .contains("1000000")
    );
    assert_eq!(range("1..1000000").unwrap().unwrap().len(), 1_000_000);
}

#[test]
fn a_list_mixes_values_and_ranges() {
    assert_eq!(list("3,1..3, 9").unwrap(), ["3", "1", "2", "3", "9"]);
    assert_eq!(list("").unwrap(), [""]);
}

#[test]
fn a_command_that_runs_once_takes_one_value() {
    assert!(key_value("a.b=../c.toml").is_ok());
    assert!(key_value("a=[1, 2]").is_ok());
    for (text, says) in [
        ("eed", "KEY=VALUE"),
        ("=1", "KEY=VALUE"),
        ("a=1..5", "hil sweep SCENE --set a=1..5"),
        ("a=5..1", "hil sweep"),
    ] {
        let refused = key_value(text).unwrap_err();
        assert!(refused.contains(says), "{refused}");
    }
}
