//! Tests of `json.rs`.

use serde_json::json;

use super::*;

fn text(value: &serde_json::Value) -> String {
    let mut out = Vec::new();
    write_json(value, &mut out).unwrap();
    String::from_utf8(out).unwrap()
}

#[test]
fn what_binary_fractions_leave_behind_is_not_written() {
    for (value, written) in [
        (1.5310000000000001, "1.531"),
        (-21.618000000000002, "-21.618"),
        (-0.17200000000000001, "-0.172"),
        (f64::from(4.2_f32), "4.2"),
        (f64::from(99.59961_f32), "99.59961"),
        (4284.8859999999995, "4284.886"),
        (34.860757209, "34.860757209"),
        (0.0, "0.0"),
        (-0.0, "-0.0"),
        (1e300, "1e+300"),
        (5e-324, "5e-324"),
        (f64::MAX, "1.79769313486e+308"),
    ] {
        assert_eq!(text(&json!(value)), written);
    }
    assert_eq!(text(&json!(u64::MAX)), "18446744073709551615");
    assert_eq!(
        text(&json!({"a": [1, null], "b": "0.1"})),
        r#"{"a":[1,null],"b":"0.1"}"#
    );
}

#[test]
fn no_number_moves_by_more_than_its_twelfth_digit() {
    let mut value = 1.0e-12_f64;
    while value < 1e12 {
        value *= 1.37;
        let off = (rounded(value) - value).abs();
        assert!(off <= value * 1e-7, "{value}");
        let near_single = f64::from(value as f32).total_cmp(&value).is_eq();
        assert!(near_single || off <= value * 1e-11, "{value}");
        assert_eq!(rounded(-value).to_bits(), (-rounded(value)).to_bits());
    }
}

#[test]
fn lines_are_those_of_serde() {
    let value = json!({"a": [1, 2.5], "b": {}});
    let mut out = Vec::new();
    write_json_lines(&value, &mut out).unwrap();
    let plain = serde_json::to_string_pretty(&value).unwrap();
    assert_eq!(String::from_utf8(out).unwrap(), plain);
}
