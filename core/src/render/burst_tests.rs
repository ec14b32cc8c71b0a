//! Tests of `burst.rs`.

use super::*;
use crate::guard::{HARD, Plant};
use crate::illusion::DisplayWire;
use crate::units::{Board, Channel, Point, Prescale};
use alloc::vec::Vec;

/// 5.07904 ms.
const CARRIER: Prescale = Prescale::new(30);
const LONGEST: Duration = Duration::from_millis(35);

fn periods(pulses: u128) -> Periods {
    Periods::new(pulses, CARRIER.period_ns(), LONGEST)
}

fn runs(pulses: u128) -> Vec<(u64, u64)> {
    let us = |run: Run| (run.at.as_micros(), run.until.as_micros());
    periods(pulses).runs().map(us).collect()
}

#[test]
fn runs_end_in_the_middle_of_their_last_period() {
    assert_eq!(runs(0), []);
    assert_eq!(runs(0b1), [(0, 2_539)]);
    let some = [(0, 2_539), (10_158, 17_776), (30_474, 33_013)];
    assert_eq!(runs(0b100_1101), some);
    // Nothing goes beyond the longest.
    assert_eq!(runs(0b1111_1111), [(0, 35_000)]);
    // A burst of all periods that there are.
    let all = Periods::new(u128::MAX, 1000, LONGEST);
    assert_eq!(all.runs().count(), 1);
    assert_eq!(all.count(), 128);
}

#[test]
fn a_wire_with_fewer_pulses_ends_with_the_last_of_them() {
    let lasts = |pulses, n| periods(pulses).lasts(n).as_micros();
    assert_eq!(
        [1, 2, 3].map(|n| lasts(0b100_1001, n)),
        [2_539, 17_776, 33_013]
    );
    assert_eq!([6, 7].map(|n| lasts(0b111_1111, n)), [27_934, 33_013]);
    // More than there are last as long as the burst may.
    assert_eq!(lasts(0b1, 2), 35_000);
    assert_eq!(
        Burst::Woven(periods(0b100_1001)).pulses(CARRIER.period_ns()),
        3
    );
    assert_eq!(Burst::Long(LONGEST).pulses(CARRIER.period_ns()), 7);
    assert_eq!(Burst::Long(LONGEST).lasts(3), LONGEST);
}

#[test]
fn fewer_pulses_are_wider_by_the_root() {
    let widened = |pulses, width, widest| {
        let burst = Burst::Woven(periods(pulses));
        burst.widened(Ticks::new(width), Ticks::new(widest)).get()
    };
    // Three of seven, and none left out.
    assert_eq!(widened(0b100_1001, 40, 148), 61);
    assert_eq!(widened(0b100_1001, 100, 148), 148);
    assert_eq!(widened(0b111_1111, 40, 148), 40);
    let long = Burst::Long(LONGEST);
    assert_eq!(long.widened(Ticks::new(40), Ticks::new(30)), Ticks::new(40));
}

#[test]
fn a_woven_burst_is_booked_run_by_run() {
    let wire = DisplayWire {
        place: Point::new(0.0, 0.0),
        board: Board(0),
        channel: Channel(0),
    };
    let guard = Guard::new(HARD, Plant::default(), &[wire]).unwrap();
    let width = Ticks::new(100);
    let one = guard.energy_nj(width, Duration::from_micros(2_539));
    let booked = |pulses, ms| {
        Burst::Woven(periods(pulses)).energy_nj(&guard, width, Duration::from_millis(ms))
    };
    assert_eq!(booked(0b100_1001, 35), 3 * one);
    assert_eq!(booked(0b100_1001, 20), 2 * one);
    assert_eq!(booked(0b100_1001, 15), one);
    let two = guard.energy_nj(width, Duration::from_micros(7_618));
    assert_eq!(booked(0b101_1001, 35), one + two + one);
    assert_eq!(
        Burst::Long(LONGEST).energy_nj(&guard, width, Duration::from_millis(20)),
        guard.energy_nj(width, Duration::from_millis(20))
    );
    // A whole period would be booked as two pulses.
    let whole = guard.energy_nj(width, Duration::from_micros(5_079));
    assert!(3 * whole > 4 * one, "{whole} nJ, {one} nJ");
}
