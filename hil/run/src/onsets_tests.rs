//! Shares of onsets, and when they are a verdict.

use super::*;

fn of(felt: u64, meant: u64) -> Onsets {
    Onsets {
        meant,
        felt: Some(felt),
        ..Onsets::default()
    }
}

#[test]
fn half_of_the_onsets_is_enough_and_less_is_not() {
    assert!(!of(78, 156).mostly_unfelt());
    assert!(of(72, 156).mostly_unfelt());
    assert!(!of(0, 0).mostly_unfelt(), "nothing was to be felt");
    let real = Onsets {
        meant: 9,
        ..Onsets::default()
    };
    assert!(!real.mostly_unfelt(), "no person is emulated");
    assert_eq!(real.felt_percent(), None);
}

#[test]
fn a_share_is_whole_only_where_all_are_in_it() {
    assert_eq!(of(999, 1000).felt_percent(), Some(99));
    assert_eq!(of(7, 7).felt_percent(), Some(100));
    assert_eq!(of(0, 0).felt_percent(), None);
    let off = |off_pad, touched| Onsets {
        touched,
        off_pad,
        ..Onsets::default()
    };
    assert_eq!(off(1, 1000).off_percent(), Some(1));
    assert_eq!(off(0, 0).off_percent(), None);
    assert!(!off(5, 10).mostly_off() && off(6, 10).mostly_off());
}

#[test]
fn tallies_of_displays_add() {
    let mut all = Onsets::default();
    all.join(&of(3, 4));
    all.join(&Onsets::default());
    all.join(&of(1, 2));
    assert_eq!(all, of(4, 6));
}
