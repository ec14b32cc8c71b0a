//! Tests of `words.rs`.

use super::*;

#[test]
fn what_differs_stands_between_what_does_not() {
    assert_eq!(
        change("tau_d 35.000 ms", "tau_d 40.079 ms"),
        "tau_d 35.000 -> 40.079 ms"
    );
    assert_eq!(change("a b", "a b c"), "a b nothing -> c");
    assert_eq!(change("x x", "x x x"), "x x nothing -> x");
    assert_eq!(change("", ""), "nothing -> nothing");
    assert_eq!(change("a  b", "a b"), "`a  b` -> `a b`");
    assert_eq!(item_key("916 in contact"), "in");
    assert_eq!(item_key("12"), "12");
}

#[test]
fn numbers_lose_their_zeros_and_keep_their_sign() {
    assert_eq!(ms(5_079), "5.079 ms");
    assert_eq!(ms(5_000), "5 ms");
    assert_eq!(signed(-2_100), "-2.1");
}
