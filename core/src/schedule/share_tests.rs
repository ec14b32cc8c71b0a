//! Tests of `share.rs`.

use super::*;
use proptest::prelude::*;

const SET: Share = Share {
    peak: Milliamps(990),
    narrowest: Ticks::new(40),
};

#[test]
fn a_level_has_less_width_and_then_less_current() {
    let of = |share: Share, width| {
        let s = share.stimulus(Ticks::new(width));
        (s.width.get(), s.peak.0)
    };
    let set = [0, 1, 10, 39, 40, 100].map(|w| of(SET, w));
    let expected = [
        (0, 990),
        (40, 156),
        (40, 495),
        (40, 977),
        (40, 990),
        (100, 990),
    ];
    assert_eq!(set, expected);
    let fixed = [0, 1, 10, 100].map(|w| of(Share::width(Milliamps(990)), w));
    assert_eq!(fixed, [(0, 990), (1, 990), (10, 990), (100, 990)]);
}

proptest! {
    #[test]
    fn the_energy_is_the_same_to_a_milliampere_and_never_more(width in 1..4096u16, full in 100..5000u32, least in 0..200u16) {
        let share = Share { peak: Milliamps(full), narrowest: Ticks::new(least) };
        let s = share.stimulus(Ticks::new(width));
        let energy = |ticks: u16, milliamps: u32| u64::from(ticks) * u64::from(milliamps).pow(2);
        let wanted = energy(width, full);
        prop_assert!(energy(s.width.get(), s.peak.0) <= wanted);
        prop_assert!(energy(s.width.get(), s.peak.0 + 1) >= wanted);
        prop_assert!(s.width >= Ticks::new(least.min(width)));
    }
}
