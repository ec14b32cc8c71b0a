//! A run after others meets the guard that one long run would have.

use proptest::prelude::*;

use super::*;
use crate::guard::{HARD, Plant};
use crate::illusion::DisplayWire;
use crate::schedule::Stimulus;
use crate::units::{Board, Channel, Duration, Milliamps, Point, Prescale, Ticks};

fn guard() -> Guard {
    let wire = |channel| DisplayWire {
        place: Point::new(f32::from(channel), 0.0),
        board: Board(0),
        channel: Channel(channel),
    };
    let plant = Plant {
        prescale: Prescale::new(30),
        wire_milliohm: 1900,
        peak: Milliamps(990),
        bus: Duration::ZERO,
    };
    Guard::new(HARD, plant, &[wire(0), wire(1)]).unwrap()
}

/// Drives a burst; what was booked, if anything passed.
fn drive(guard: &mut Guard, at_ms: u64, wire: u16, width: u16) -> Option<(u16, Booked)> {
    let at = Instant::from_micros(1000 * at_ms);
    let stimulus = Stimulus {
        wire,
        width: Ticks::new(width),
        peak: Milliamps(990),
        at,
        until: at + Duration::from_millis(35),
    };
    let mut entry = None;
    let _ = guard.change(at, Board(0), &[stimulus], |e| entry = Some(e));
    let entry = entry?;
    let _ = guard.expire(entry.until, Board(0));
    let booked = guard.booked([&entry].into_iter()).next()?;
    (entry.width() > Ticks::ZERO).then_some((wire, booked))
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    /// Runs one after the other, each with a guard that remembers those before, and one guard through all of them.
    #[test]
    fn what_is_remembered_is_what_one_long_run_has(
        runs in prop::collection::vec(
            (prop::collection::vec((60u64..900, 0u16..2, 10u16..140), 1..12), 500u64..20_000),
            1..6,
        ),
    ) {
        let mut whole = guard();
        let mut earlier = Earlier::default();
        for (bursts, pause_ms) in &runs {
            let mut alone = guard();
            alone.remember(&earlier);
            let began = earlier.until;
            let offset_ms = began.as_micros() / 1000;
            let (mut at_ms, mut passed) = (0, Vec::new());
            for (gap_ms, wire, width) in bursts {
                at_ms += gap_ms;
                let one = drive(&mut alone, at_ms, *wire, *width);
                let other = drive(&mut whole, offset_ms + at_ms, *wire, *width);
                prop_assert_eq!(one.is_some(), other.is_some());
                if let (Some(one), Some(other)) = (one, other) {
                    // Integers either way, up to the rounding of what is left.
                    prop_assert!(one.1.energy_nj.abs_diff(other.1.energy_nj) <= one.1.energy_nj / 50 + 1);
                    passed.push(one);
                }
            }
            let now = Instant::from_micros(1000 * (at_ms + 100));
            let then = Instant::from_micros(1000 * (offset_ms + at_ms + 100));
            for ((row, one), (_, other)) in alone.used(now).rows().into_iter().zip(whole.used(then).rows()) {
                prop_assert!((one - other).abs() < 0.02, "{row}: {one} {other}");
            }
            earlier.extend(began, passed);
            let end = offset_ms + at_ms + pause_ms;
            earlier.until = earlier.until.max(Instant::from_micros(1000 * end));
        }
    }
}

#[test]
fn bursts_of_a_run_are_as_late_as_it_began() {
    let us = Instant::from_micros;
    let burst = |on, off| Booked {
        on: us(on),
        off: us(off),
        energy_nj: 7,
    };
    let mut earlier = Earlier::default();
    earlier.extend(Instant::ZERO, [(0, burst(5_000, 40_000))]);
    assert_eq!(earlier.until, us(40_000));
    earlier.extend(us(100_000), [(1, burst(0, 35_000)), (0, burst(0, 10_000))]);
    let late = [(1, burst(100_000, 135_000)), (0, burst(100_000, 110_000))];
    assert_eq!(earlier.bursts[0], (0, burst(5_000, 40_000)));
    assert_eq!(earlier.bursts[1..], late);
    assert_eq!(earlier.until, us(135_000));
}

#[test]
fn heat_and_dose_of_earlier_runs_count() {
    let mut first = guard();
    let bursts: Vec<_> = (0..200)
        .filter_map(|n| drive(&mut first, 117 * n, 0, 60))
        .collect();
    let mut earlier = Earlier::default();
    earlier.extend(Instant::ZERO, bursts);
    let mut next = guard();
    next.remember(&earlier);
    let used = next.used(Instant::ZERO);
    let before = first.used(earlier.until);
    assert!(
        used.cem43 > 0.9 * before.cem43 && used.cem43 > 0.0,
        "{used:?} {before:?}"
    );
    assert!(used.skin_mean > 0.3, "{used:?}");
    let spent = (used.wire_power, before.wire_power);
    assert!(
        spent.0 > 0.01 && (spent.0 - spent.1).abs() < 1e-6,
        "{spent:?}"
    );
    assert!(next.predicted().peak_c > guard().predicted().peak_c + 1.0);
    // The other wire's skin is cold, the fingertip's power is not.
    let far = Earlier {
        until: earlier.until + Duration::from_millis(3_600_000),
        ..earlier
    };
    let mut later = guard();
    later.remember(&far);
    let rested = later.used(Instant::ZERO);
    assert!(
        rested.skin_mean < 0.02 && rested.wire_power < 1e-6,
        "{rested:?}"
    );
    assert!(rested.cem43 >= used.cem43, "{rested:?}");
}

#[test]
fn wires_that_are_not_there_are_left_out() {
    let mut guard = guard();
    let burst = Booked {
        on: Instant::ZERO,
        off: Instant::from_micros(35_000),
        energy_nj: 1_000_000,
    };
    guard.remember(&Earlier {
        bursts: [(9, burst)].into(),
        until: burst.off,
    });
    let used = guard.used(Instant::ZERO);
    assert!(
        used.rows().iter().all(|(_, share)| *share < 1e-6),
        "{used:?}"
    );
}
