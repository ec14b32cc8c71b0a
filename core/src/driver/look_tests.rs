//! Tests of `look.rs`.

use super::*;

#[test]
fn full_off_wins_over_full_on_and_equal_counts_make_no_pulse() {
    for (quad, pulse) in [
        ([0, 0, 0, 0x10], false),
        ([0, 0x10, 0, 0x10], false),
        ([0, 0x10, 0, 0], true),
        ([7, 1, 7, 1], false),
        ([7, 0xE1, 7, 1], false), // the upper bits are reserved
        ([7, 1, 8, 1], true),
        ([7, 1, 7, 2], true),
    ] {
        assert_eq!(makes_a_pulse(quad), pulse, "{quad:02x?}");
    }
}

#[test]
fn a_chip_asleep_drives_nothing() {
    let seen = Seen {
        mode1: mode1::RESET,
        mode2: 4,
        prescale: 30,
        loaded: 3,
    };
    assert_eq!(seen.driving(), 0);
    assert_eq!(Seen { mode1: 0, ..seen }.driving(), 3);
}
