//! What is said of a session is what the guard then does.

use super::*;
use crate::guard::{HARD, Limits, Plant, WornWire};
use crate::illusion::DisplayWire;
use crate::schedule::{Reason, Stimulus};
use crate::units::{Board, Channel, Milliamps, Point, Prescale, Ticks};

const DAY: Duration = Duration::from_millis(24 * 3_600_000);

/// One wire.
fn guard(limits: Limits) -> Guard {
    let wire = DisplayWire {
        place: Point::new(0.0, 0.0),
        board: Board(0),
        channel: Channel(0),
    };
    let plant = Plant {
        prescale: Prescale::new(30),
        wire_milliohm: 1900,
        peak: Milliamps(990),
        bus: Duration::ZERO,
    };
    Guard::new(limits, plant, &[wire], WornWire::default()).unwrap()
}

/// Width of the pulses and length of each burst, ms, and when it comes in a round, ms.
type Bursts<'a> = &'a [(u16, u64, u64)];

/// A round's entries as the guard passes them from rest, and when the dose row first narrows one of many rounds.
fn drive(guard: &mut Guard, bursts: Bursts<'_>, period_ms: u64) -> (alloc::vec::Vec<Booked>, f64) {
    let mut first = alloc::vec::Vec::new();
    for round in 0..2_000_000 {
        for (width, length_ms, at_ms) in bursts {
            let at = Instant::from_micros(1000 * (round * period_ms + at_ms));
            let stimulus = Stimulus {
                wire: 0,
                width: Ticks::new(*width),
                peak: Milliamps(990),
                at,
                until: at + Duration::from_millis(*length_ms),
            };
            let mut entry = None;
            let _ = guard.admit(at, Board(0), &[stimulus], |e| entry = Some(e));
            let entry = entry.unwrap();
            if entry.reason == Some(Reason::Dose) {
                return (first, at.since(Instant::ZERO).as_secs_f64());
            }
            assert_eq!(entry.reason, None, "another row at {at:?}");
            if round == 0 {
                first.extend(guard.booked([&entry].into_iter()));
            }
            let _ = guard.expire(entry.until, Board(0));
        }
    }
    panic!("no dose in {period_ms} ms times two million");
}

#[test]
fn a_session_lasts_until_the_guard_makes_bursts_weaker() {
    let cases: [(Bursts<'_>, u64, u64); 4] = [
        (&[(60, 35, 0)], 117, 5_000),
        (&[(80, 35, 0)], 117, 40_000),
        (&[(120, 10, 0)], 117, 5_000),
        (&[(80, 35, 0), (80, 35, 117), (80, 35, 400)], 700, 5_000),
    ];
    for (bursts, period_ms, dose_ms) in cases {
        let limits = Limits {
            dose_cem43_ms: dose_ms,
            ..HARD
        };
        let mut guard = guard(limits);
        let fresh = guard.clone();
        let (round, seconds) = drive(&mut guard, bursts, period_ms);
        let period = Duration::from_millis(period_ms);
        let said = fresh.lasts(&round, period, DAY).unwrap();
        let longer = said + Duration::from_millis(1);
        assert_eq!(fresh.lasts(&round, period, longer), Some(said));
        assert_eq!(fresh.lasts(&round, period, said), None);
        let error = said.as_secs_f64() / seconds - 1.0;
        // Chords between temperatures end elsewhere.
        assert!(error.abs() < 0.03, "{bursts:?}: {said:?} said, {seconds} s");
    }
}

#[test]
fn what_hardly_warms_lasts_a_day_and_nonsense_does_no_harm() {
    let guard = guard(HARD);
    let burst = |on, off, energy_nj| Booked {
        on: Instant::from_micros(on),
        off: Instant::from_micros(off),
        energy_nj,
    };
    let period = Duration::from_millis(117);
    assert_eq!(guard.lasts(&[], period, DAY), None);
    assert_eq!(guard.lasts(&[burst(0, 35_000, 1000)], period, DAY), None);
    let endless = [burst(9, 3, u64::MAX), burst(0, 0, u64::MAX)];
    let at_once = guard.lasts(&endless, Duration::ZERO, DAY).unwrap();
    assert!(at_once <= Duration::from_millis(1), "{at_once:?}");
}
