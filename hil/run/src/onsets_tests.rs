//! Shares of onsets, and when they are a verdict.

use super::*;

fn onsets(felt: u64, meant: u64) -> Onsets {
    Onsets {
        meant,
        felt: Some(felt),
        ..Onsets::default()
    }
}

#[test]
fn half_of_the_onsets_is_enough_and_less_is_not() {
    assert!(!onsets(78, 156).mostly_unfelt());
    assert!(onsets(72, 156).mostly_unfelt());
    assert!(!onsets(0, 0).mostly_unfelt(), "nothing was to be felt");
    let real = Onsets {
        meant: 9,
        ..Onsets::default()
    };
    assert!(!real.mostly_unfelt(), "no person is emulated");
    assert_eq!(real.felt_percent(), None);
}

#[test]
fn a_share_is_whole_only_where_all_are_in_it() {
    assert_eq!(onsets(999, 1000).felt_percent(), Some(99));
    assert_eq!(onsets(7, 7).felt_percent(), Some(100));
    assert_eq!(onsets(0, 0).felt_percent(), None);
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
    all.join(&onsets(3, 4));
    all.join(&Onsets::default());
    all.join(&onsets(1, 2));
    assert_eq!(all, onsets(4, 6));
}
