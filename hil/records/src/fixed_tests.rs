//! Tests of `fixed.rs`.

use super::*;

#[test]
fn fractions_keep_their_sign_below_one() {
    assert_eq!(milli(-50), "-0.050");
    assert_eq!(milli(i64::MIN), "-9223372036854775.808");
    assert_eq!(milli_u(12_345), "12.345");
    assert_eq!(place(PlaceUm { x: -7_050, y: 4 }), "(-7.05, +0.00) mm");
}

#[test]
fn what_is_printed_is_read_back() {
    for value in [0, -50, 12_345, i64::MAX, -i64::MAX] {
        assert_eq!(thousandths(&milli(value)), Some(value));
    }
    assert_eq!(thousandths("12"), Some(12_000));
    for text in ["", "-", "1.5", "1.-50", "+1", "9223372036854775808"] {
        assert_eq!(thousandths(text), None, "{text}");
    }
}

#[test]
fn distance_survives_the_extremes() {
    let a = PlaceUm {
        x: i32::MIN,
        y: i32::MIN,
    };
    let b = PlaceUm {
        x: i32::MAX,
        y: i32::MAX,
    };
    assert_eq!(distance2_um(a, b), u64::MAX);
}
