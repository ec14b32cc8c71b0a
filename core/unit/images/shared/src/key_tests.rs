//! Tests of `key.rs`.

use super::*;

#[test]
fn a_key_is_its_digits() {
    const KEY: [u8; 32] = key("00ff0123456789abCDEF00000000000000000000000000000000000000000009");
    assert_eq!(KEY[..8], [0, 0xFF, 1, 0x23, 0x45, 0x67, 0x89, 0xAB]);
    assert_eq!(KEY[31], 9);
}

#[test]
#[should_panic = "64 hexadecimal digits"]
fn a_short_key_is_refused() {
    key("00ff");
}

#[test]
#[should_panic = "found zeros"]
fn a_key_of_zeros_is_refused() {
    key("0000000000000000000000000000000000000000000000000000000000000000");
}

#[test]
fn fingertips_fill_boards_one_after_the_other() {
    let wires = fingertips::<16>(8);
    assert_eq!((wires[7].board, wires[7].channel), (Board(0), Channel(7)));
    assert_eq!((wires[8].board, wires[8].channel), (Board(1), Channel(0)));
}
