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
fn an_all_off_leaves_the_trace_of_a_pulse_and_none_of_a_channel_that_was_off() {
    for (quad, pulse) in [
        ([0, 0, 0, 0x10], false),
        ([7, 1, 7, 0x10], false), // ended, then all off
        ([7, 1, 20, 0x10], true),
        ([7, 0x10, 7, 0x10], true), // was full on
        ([7, 1, 20, 1], false),     // drives now
        ([7, 1, 7, 0x11], false),   // ended, no all-off
    ] {
        assert_eq!(made_a_pulse(quad), pulse, "{quad:02x?}");
    }
}

#[test]
fn a_chip_asleep_drives_nothing() {
    let seen = Seen {
        mode1: mode1::RESET,
        mode2: 4,
        prescale: 30,
        loaded: 3,
        stopped: 5,
    };
    assert_eq!((seen.driving(), seen.drove()), (0, 0));
    let awake = Seen { mode1: 0, ..seen };
    assert_eq!((awake.driving(), awake.drove()), (3, 5));
}
