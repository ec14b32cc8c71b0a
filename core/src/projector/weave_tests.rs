//! Tests of `weave.rs`.

use super::*;
use crate::guard::{HARD, Plant, WornWire};
use crate::illusion::DisplayWire;
use crate::units::{Board, Channel, Point};
use alloc::vec::Vec;

/// 5.07904 ms.
const CARRIER: Prescale = Prescale::new(30);
const START: Instant = Instant::from_micros(58_500);
const BURST: Duration = Duration::from_millis(35);

fn weave(rate_hz: u32) -> Weave {
    let control = Control {
        delta_mu: Duration::ZERO,
        sigma: Duration::from_millis(1),
        rate_mhz: 1000 * rate_hz,
    };
    Weave::new(START, BURST, CARRIER, &control)
}

/// Beginnings and ends of its pulses since the burst began, played on time.
fn played(mut weave: Weave) -> Vec<(u64, u64)> {
    let mut runs = Vec::new();
    while weave.next() < Instant::FAR_FUTURE {
        let (at, until) = weave.due(weave.next()).unwrap();
        runs.push((at.since(START).as_micros(), until.since(START).as_micros()));
    }
    runs
}

#[test]
fn a_smooth_burst_is_whole_and_a_rough_one_has_every_third_period() {
    assert_eq!(played(weave(200)), [(0, 35_000)]);
    let third = [(0, 5_079), (15_237, 20_316), (30_474, 35_000)];
    assert_eq!(played(weave(66)), third);
    let half = played(weave(100));
    assert_eq!(half.first(), Some(&(0, 5_079)));
    assert_eq!(half.len(), 4);
}

#[test]
fn every_burst_begins_with_a_pulse_and_pulses_grow_with_the_rate() {
    let mut before = 0;
    for rate_hz in 1..=1500 {
        let weave = weave(rate_hz);
        let pulses = weave.pulses.count_ones();
        assert!(weave.pulses & 1 == 1 && pulses >= before && pulses <= 7);
        before = pulses;
    }
    assert_eq!(before, 7);
}

#[test]
fn the_renderer_hears_of_what_the_guard_will_book() {
    let wire = DisplayWire {
        place: Point::new(0.0, 0.0),
        board: Board(0),
        channel: Channel(0),
    };
    let guard = Guard::new(HARD, Plant::default(), &[wire], WornWire::default()).unwrap();
    let width = Ticks::new(60);
    for (rate_hz, pulses) in [(200, 7), (100, 4), (66, 3)] {
        let weave = weave(rate_hz);
        let stated = weave.stated(&guard);
        assert_eq!((stated.length, stated.woven), (BURST, Some(pulses)));
        let runs = played(weave).into_iter();
        let spans = runs.map(|(from, to)| Duration::from_micros(to - from));
        let booked: u64 = spans.map(|span| guard.energy_nj(width, span)).sum();
        let whole = guard.energy_nj(width, BURST) as f32;
        let off = booked as f32 - stated.booked * whole;
        assert!(off.abs() < 1e-3 * whole, "{rate_hz}: {stated:?} {booked}");
    }
    assert!((weave(200).stated(&guard).booked - 1.0).abs() < 1e-6);
}

#[test]
fn fewer_pulses_are_wider_by_the_root() {
    let of = |rate_hz: u32| gain(1000 * rate_hz, CARRIER.period_ns());
    assert!((of(49) - 2.004_5).abs() < 1e-3, "{}", of(49));
    assert!((of(197) - 1.0).abs() < 1e-6 && (of(1500) - 1.0).abs() < 1e-6);
    assert!(of(0).is_finite());
}

#[test]
fn missed_pulses_are_left_out() {
    let mut late = weave(66);
    let now = START + Duration::from_millis(17);
    let due = late.due(now).map(|(at, _)| at.since(START).as_micros());
    assert_eq!(due, Some(15_237));
    assert_eq!(late.due(START + Duration::from_millis(40)), None);
    assert_eq!(late.next(), Instant::FAR_FUTURE);
}

#[test]
fn wires_widen_alike_and_never_past_the_limit() {
    let ticks = |values: [u16; 3]| values.map(Ticks::new);
    let widened = |rate_hz, widths| {
        let mut widths = ticks(widths);
        weave(rate_hz).widen(&mut widths, Ticks::new(148));
        widths
    };
    assert_eq!(widened(66, [0, 40, 80]), ticks([0, 61, 122])); // root of 7 / 3
    assert_eq!(widened(66, [0, 50, 100]), ticks([0, 74, 148]));
    assert_eq!(widened(200, [0, 50, 100]), ticks([0, 50, 100]));
    // What is too wide already, the guard narrows.
    assert_eq!(widened(66, [0, 50, 160]), ticks([0, 50, 160]));
    assert_eq!(widened(66, [0; 3]), ticks([0; 3]));
}
