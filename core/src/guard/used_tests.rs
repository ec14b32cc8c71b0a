//! Shares are what the guard decides by: never above one for what it passed, and gone when it has rested.

use alloc::vec::Vec;

use proptest::prelude::*;

use super::*;
use crate::guard::{HARD, Plant, WornWire};
use crate::illusion::DisplayWire;
use crate::schedule::Stimulus;
use crate::units::{Board, Channel, Duration, Milliamps, Point, Prescale, Ticks};

fn guard(heat: bool) -> Guard {
    let wire = |c: u8| DisplayWire {
        place: Point::new(f32::from(c), 0.0),
        board: Board(0),
        channel: Channel(c),
    };
    let wires: Vec<_> = (0..4).map(wire).collect();
    let plant = Plant {
        prescale: Prescale::new(30),
        wire_milliohm: 1900,
        peak: Milliamps(1970),
        bus: Duration::ZERO,
    };
    let limits = crate::guard::Limits {
        supply: Milliamps(4000),
        ..HARD
    };
    Guard::last_word(limits, plant, &wires, heat.then(WornWire::default)).unwrap()
}

fn drive(guard: &mut Guard, wire: u16, width: u16, at_us: u64, length_us: u64) {
    let at = Instant::from_micros(at_us);
    let stimulus = Stimulus {
        wire,
        width: Ticks::new(width),
        peak: Milliamps(1970),
        at,
        until: Instant::from_micros(at_us + length_us),
    };
    while let Some(end) = guard.next_expiry().filter(|end| *end <= at) {
        guard.expire(end, Board(0));
    }
    guard.change(at, Board(0), &[stimulus], |_| ());
}

#[test]
fn rest_uses_nothing() {
    assert_eq!(
        guard(true)
            .used(Instant::from_micros(5_000_000))
            .rows()
            .map(|r| r.1)[..9],
        [0.0; 9]
    );
    assert_eq!(guard(false).used(Instant::ZERO), Used::default());
}

#[test]
fn a_burst_is_told_while_it_goes_on() {
    let mut guard = guard(true);
    drive(&mut guard, 1, 120, 1_000_000, 40_000);
    let half = guard.used(Instant::from_micros(1_020_000));
    let whole = guard.used(Instant::from_micros(1_040_000));
    assert!(whole.burst > 0.8 && (half.burst - whole.burst / 2.0).abs() < 1e-9);
    let widest = f64::from(guard.widest().get());
    assert!((half.pulse - 120.0 / widest).abs() < 1e-12);
    assert!((half.supply - 1970.0 / 4000.0).abs() < 1e-12);
    let booked = guard.energy_nj(Ticks::new(120), Duration::from_millis(40));
    let energy = booked as f64 / HARD.burst_energy_nj as f64;
    assert!((half.burst_energy - energy).abs() < 1e-12, "{half:?}");
    assert!(half.wire_power > half.fingertip_power && half.fingertip_power > 0.0);
    assert!(half.skin_peak > half.skin_deep && half.skin_deep > 0.0);
    guard.expire(Instant::from_micros(1_041_000), Board(0));
    let after = guard.used(Instant::from_micros(2_000_000));
    assert_eq!(
        (after.pulse, after.burst, after.burst_energy, after.supply),
        (0.0, 0.0, 0.0, 0.0)
    );
}

#[test]
fn without_thermal_rows_they_are_not_used() {
    let mut guard = guard(false);
    drive(&mut guard, 0, 120, 1_000_000, 40_000);
    let used = guard.used(Instant::from_micros(1_000_000));
    assert!(used.wire_power > 0.0);
    assert_eq!((used.skin_peak, used.omega), (0.0, 0.0));
}

proptest! {
    /// Whatever is asked, what was passed is within every limit, at any later time; reading changes nothing.
    #[test]
    fn what_passed_stays_below_one(
        asked in proptest::collection::vec((0u16..4, 1u16..4096, 1u64..60_000, 0u64..300_000), 1..60),
        later in 0u64..30_000_000,
    ) {
        let (mut guard, mut now) = (guard(true), 1_000_000);
        let twin = &mut guard.clone();
        for (wire, width, length, pause) in asked {
            now += pause;
            drive(&mut guard, wire, width, now, length);
            drive(twin, wire, width, now, length);
            for at in [now, now + later] {
                let used = guard.used(Instant::from_micros(at));
                for (row, share) in used.rows() {
                    prop_assert!((0.0..=1.0 + 1e-9).contains(&share), "{row}: {share}");
                }
            }
        }
        let at = Instant::from_micros(now + 500_000);
        prop_assert_eq!(guard.budget(0, at, at + Duration::from_millis(30)), twin.budget(0, at, at + Duration::from_millis(30)));
        guard.expire(at, Board(0));
        let rested = guard.used(Instant::from_micros(now + 3_600_000_000));
        for (row, share) in &rested.rows()[..9] {
            prop_assert!(*share < 1e-3, "{}: {}", row, share);
        }
    }
}

#[test]
fn a_share_of_nothing_is_nothing_or_all() {
    assert_eq!((share(0, 0), share(3, 0)), (0.0, 1.0));
    assert_eq!((share(0, 4), share(1, 4), share(4, 4)), (0.0, 0.25, 1.0));
}

#[test]
fn every_row_has_its_name_and_share() {
    let used = Used {
        pulse: 0.1,
        burst: 0.2,
        skin_mean: 0.7,
        cem43: 1.1,
        ..Used::default()
    };
    let rows = used.rows();
    assert_eq!(rows[..2], [("pulse", 0.1), ("burst", 0.2)]);
    assert_eq!((rows[6], rows[10]), (("skin_mean", 0.7), ("cem43", 1.1)));
    let mut names = rows.map(|(name, _)| name);
    names.sort_unstable();
    assert!(names.windows(2).all(|pair| pair[0] != pair[1]), "{names:?}");
}
