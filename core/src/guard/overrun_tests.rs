//! Tests of `overrun.rs`: a channel is on until it is known to be off.

use alloc::vec;
use alloc::vec::Vec;

use proptest::prelude::*;

use super::*;
use crate::guard::{Cause, CurrentControl, HARD, Limits, Plant, WornWire};
use crate::illusion::DisplayWire;
use crate::schedule::Stimulus;
use crate::units::{Board, Channel, Milliamps, Point, Prescale, Ticks};

/// How long a wire may be on: 50 ms, a period of 5.521 ms at the slowest clock, and the bus's millisecond.
const LONGEST_US: u64 = 56_521;

const fn us(us: u64) -> Instant {
    Instant::from_micros(us)
}

/// Two wires on the first of two boards, one on the second.
fn guard() -> Guard {
    guard_of(HARD, Prescale::new(30))
}

fn guard_of(limits: Limits, prescale: Prescale) -> Guard {
    let wire = |(board, channel): (u8, u8)| DisplayWire {
        place: Point::new(f32::from(channel), f32::from(board)),
        board: Board(board),
        channel: Channel(channel),
    };
    let wires: Vec<_> = [(0, 0), (0, 5), (1, 0)].map(wire).into();
    let plant = Plant {
        prescale,
        ..Plant::default()
    };
    Guard::new(limits, plant, &wires, WornWire::default()).unwrap()
}

fn stimulus(wire: u16, width: u16, at_us: u64, length_us: u64) -> Stimulus {
    Stimulus {
        wire,
        width: Ticks::new(width),
        peak: Milliamps(990),
        at: us(at_us),
        until: us(at_us + length_us),
    }
}

/// Switches a wire of the first board on at once.
fn on(guard: &mut Guard, wire: u16, at_us: u64, length_us: u64) {
    let update = guard.admit(
        us(at_us),
        Board(0),
        &[stimulus(wire, 50, at_us, length_us)],
        |_| {},
    );
    assert!(update.changes());
    guard.confirm(&update, us(at_us));
}

fn spent(guard: &Guard, wire: usize) -> u64 {
    guard.wires[wire].burst.map_or(0, |burst| burst.spent_nj)
}

#[test]
fn a_confirmation_within_the_bus_changes_nothing_and_a_later_one_books_what_flowed() {
    let booked = |asked: u64, known: Option<u64>| {
        let mut guard = guard();
        on(&mut guard, 1, 0, 35_000);
        let update = guard.expire(us(asked), Board(0));
        if let Some(known) = known {
            guard.confirm(&update, us(known));
        }
        (spent(&guard, 1), guard.predicted().peak_c)
    };
    let punctual = booked(35_000, None);
    for known in [35_000, 35_999, 36_000] {
        assert_eq!(booked(35_000, Some(known)), punctual, "{known}");
    }
    let late = booked(35_000, Some(46_000));
    assert!(late.0 > punctual.0 && late.1 > punctual.1 + 0.1, "{late:?}");
    // It is what an expiry books that was asked for as late, less the bus.
    assert_eq!(late, booked(45_000, None));
    // Late in two parts is as late as in one, on a clock whose periods can be counted.
    let counted = |asked: u64, known: u64| {
        let clock = crate::units::Clock::external(25_000_000, 100).unwrap();
        let mut guard = guard_of(HARD, Prescale::new(30).with_clock(clock));
        on(&mut guard, 1, 0, 35_000);
        let update = guard.expire(us(asked), Board(0));
        guard.confirm(&update, us(known));
        spent(&guard, 1)
    };
    assert_eq!(counted(40_000, 56_000), counted(55_000, 55_000));
    assert!(counted(40_000, 56_000) > counted(40_000, 40_000));
}

#[test]
fn what_is_released_early_is_booked_up_to_its_end_already() {
    let mut guard = guard();
    on(&mut guard, 0, 0, 35_000);
    let before = spent(&guard, 0);
    let update = guard.release(us(10_000), Board(0));
    guard.confirm(&update, us(36_000));
    assert_eq!(spent(&guard, 0), before);
    assert_eq!(guard.overrun(), None);
}

#[test]
fn a_wire_is_over_when_it_is_known_to_be_off_later_than_it_may_be_on() {
    assert_eq!(guard().longest(), us(LONGEST_US).since(Instant::ZERO));
    for (known, over) in [(LONGEST_US, false), (LONGEST_US + 1, true)] {
        let known = 700_000 + known;
        let mut by_update = guard();
        on(&mut by_update, 1, 700_000, 35_000);
        let mut by_all_off = by_update.clone();
        let mut by_look = by_update.clone();

        let update = by_update.expire(us(735_000), Board(0));
        by_update.confirm(&update, us(known));
        by_all_off.ask_off(us(735_000));
        by_all_off.all_off(us(known));
        by_look.hear(us(known));
        by_look.ask_off(us(735_000));
        let cause = by_look.watch(us(known));
        assert_eq!(cause, over.then_some(Cause::Overrun));
        for guard in [by_update, by_all_off, by_look] {
            let found = guard.overrun();
            assert_eq!((found.is_some(), guard.overran()), (over, over));
            if let Some(found) = found {
                assert_eq!((found.wire, found.on), (1, us(known).since(us(700_000))));
                assert_eq!(found.energy_nj, spent(&guard, 1));
            }
        }
    }
}

#[test]
fn what_is_off_is_looked_at_no_more() {
    let mut guard = guard();
    on(&mut guard, 1, 0, 35_000);
    let update = guard.expire(us(35_000), Board(0));
    guard.hear(us(200_000));
    // Of another board, and of the same one without that channel: neither says that it is off.
    let other = guard.admit(
        us(36_000),
        Board(1),
        &[stimulus(2, 50, 36_000, 200)],
        |_| {},
    );
    guard.confirm(&other, us(36_000));
    let beside = guard.change(
        us(37_000),
        Board(0),
        &[stimulus(0, 50, 37_000, 200)],
        |_| {},
    );
    guard.confirm(&beside, us(37_000));
    guard.all_off_of(&[0, 2], us(37_200));
    assert_eq!(guard.watch(us(200_000)), Some(Cause::Overrun));
    guard.latch(Cause::Overrun);
    assert!(!guard.overran());
    // It is still on, and still to be switched off.
    assert_eq!(guard.watch(us(200_001)), Some(Cause::Overrun));
    guard.confirm(&update, us(200_002));
    assert_eq!(guard.watch(us(300_000)), None);
    let on = guard.overrun().unwrap().on;
    assert_eq!(on, us(200_002).since(Instant::ZERO));
}

impl Guard {
    /// Some wires are known to be off, the others not.
    fn all_off_of(&mut self, wires: &[usize], at: Instant) {
        for &index in wires {
            if let Some(was) = self.wires[index].now.take() {
                self.told_off(index, was, at);
            }
            self.end(index, at);
        }
    }
}

#[test]
fn what_failed_to_go_off_is_on_and_a_wider_pulse_after_it_counts() {
    let booked = |second: u16| {
        let mut guard = guard();
        on(&mut guard, 0, 0, 10_000);
        let first = guard.expire(us(10_000), Board(0));
        assert!(first.changes()); // and fails
        let wider = [stimulus(0, second, 12_000, 10_000)];
        let update = guard.admit(us(12_000), Board(0), &wider, |_| {});
        assert!(update.changes()); // fails as well
        let all: u64 = spent(&guard, 0);
        guard.ask_off(us(22_000));
        guard.all_off(us(43_000));
        assert_eq!(guard.overrun(), None);
        spent(&guard, 0) - all
    };
    // From the end of the first until the bus's millisecond before the off, as the wider of both.
    let flowed = |width| {
        Plant::default().late_nj(width, Duration::from_millis(10), Duration::from_millis(32))
    };
    assert_eq!(booked(20), flowed(50));
    assert_eq!(booked(90), flowed(90));
}

#[test]
fn a_burst_that_never_ended_began_with_its_first_part() {
    let mut guard = guard();
    on(&mut guard, 0, 0, 10_000);
    guard.expire(us(10_000), Board(0)); // and fails
    let again = [stimulus(0, 50, 40_000, 10_000)];
    let update = guard.admit(us(40_000), Board(0), &again, |_| {});
    assert!(update.changes());
    guard.ask_off(us(50_000));
    guard.all_off(us(LONGEST_US + 1));
    assert_eq!(
        guard.overrun().unwrap().on,
        us(LONGEST_US + 1).since(Instant::ZERO)
    );
}

#[test]
fn the_longest_is_kept_and_the_most_energy() {
    let mut guard = guard();
    let wide = [stimulus(0, 100, 0, 30_000), stimulus(1, 10, 0, 30_000)];
    let update = guard.admit(Instant::ZERO, Board(0), &wide, |_| {});
    guard.confirm(&update, Instant::ZERO);
    guard.ask_off(us(30_000));
    guard.still_on(us(60_000));
    let so_far = guard.overrun().unwrap();
    assert_eq!(
        (so_far.wire, so_far.on),
        (0, us(60_000).since(Instant::ZERO))
    );
    assert_eq!(so_far.energy_nj, spent(&guard, 0));
    // It was still on, and is booked no twice.
    guard.all_off_of(&[0], us(60_000));
    assert_eq!(so_far.energy_nj, spent(&guard, 0));
    guard.all_off(us(90_000));
    let found = guard.overrun().unwrap();
    assert_eq!((found.wire, found.on), (1, us(90_000).since(Instant::ZERO)));
    assert_eq!(found.energy_nj, so_far.energy_nj);
    assert!(spent(&guard, 1) < spent(&guard, 0));
    // The way back does not undo it.
    guard.latch(Cause::ActuatorError);
    guard.hear(us(90_000));
    assert_eq!(guard.watch(us(90_000)), None);
    guard.reset(us(90_000)).unwrap();
    assert_eq!(guard.overrun(), Some(found));
}

#[test]
fn a_current_that_is_not_known_any_more_counts_as_full_scale() {
    let control = CurrentControl {
        full_scale: Milliamps(990),
        gain_ppm: 0,
        offset: Milliamps(0),
    };
    let late = |asks: bool| {
        let mut guard = guard().with_current(control).unwrap();
        for at in [0, 500_000] {
            let weak = Stimulus {
                peak: Milliamps(300),
                ..stimulus(0, 50, at, 35_000)
            };
            let update = guard.admit(us(at), Board(0), &[weak], |_| {});
            guard.confirm(&update, us(at));
            if at == 0 {
                let update = guard.expire(us(35_000), Board(0));
                guard.confirm(&update, us(35_000));
            }
        }
        let before = spent(&guard, 0);
        let update = guard.expire(us(535_000), Board(0));
        if asks {
            guard.ask_off(us(535_000));
            guard.all_off(us(546_000));
        } else {
            guard.confirm(&update, us(546_000));
        }
        spent(&guard, 0) - before
    };
    let of = |milliamps| {
        let plant = Plant {
            peak: Milliamps(milliamps),
            ..Plant::default()
        };
        plant.late_nj(50, Duration::from_millis(35), Duration::from_millis(10))
    };
    assert_eq!((late(false), late(true)), (of(300), of(990)));
}

#[test]
fn a_late_end_does_not_shorten_what_came_after_it() {
    let mut guard = guard();
    on(&mut guard, 0, 0, 10_000);
    let both = [stimulus(0, 40, 10_000, 30_000)];
    let update = guard.admit(us(10_000), Board(0), &both, |_| {});
    guard.confirm(&update, us(15_000));
    assert_eq!(guard.wires[0].burst.unwrap().end(), us(40_000));
}

#[test]
fn emulated_registers_that_are_observed_are_never_over() {
    let mut guard = guard();
    let long = [stimulus(0, 50, 0, 400_000)];
    guard
        .observe(Instant::ZERO, Board(0), &long, |_| {})
        .unwrap();
    guard.hear(us(400_000));
    guard.observe_expiry(us(400_000), Board(0)).unwrap();
    assert_eq!(guard.watch(us(400_000)), None);
    guard.all_off(us(500_000));
    assert_eq!((guard.overrun(), guard.overran()), (None, false));
    // What is driven through the guard afterwards is.
    on(&mut guard, 1, 600_000, 35_000);
    guard.ask_off(us(635_000));
    guard.all_off(us(700_000));
    assert_eq!(guard.overrun().unwrap().wire, 1);
    let mut guard = guard_of(HARD, Prescale::new(30));
    guard.observe(Instant::ZERO, Board(0), &[stimulus(0, 50, 0, 1000)], |_| {});
    guard.observe_expiry(us(1000), Board(0));
    guard.change(
        us(100_000),
        Board(0),
        &[stimulus(1, 50, 100_000, 35_000)],
        |_| {},
    );
    guard.ask_off(us(135_000));
    guard.all_off(us(200_000));
    assert_eq!(guard.overrun().unwrap().wire, 1);
}

/// What happens to two wires that are on.
#[derive(Clone, Copy, Debug)]
enum Act {
    /// What is over is told to go off, and known to be off so much later, if that arrives.
    Expire(Option<u64>),
    AskOff,
    StillOn,
    Look,
}

fn act() -> impl Strategy<Value = Act> {
    let late = prop_oneof![
        Just(None),
        (0..3_000u64).prop_map(Some),
        (0..3_000_000u64).prop_map(Some),
    ];
    prop_oneof![
        4 => late.prop_map(Act::Expire),
        1 => Just(Act::AskOff),
        1 => Just(Act::StillOn),
        1 => Just(Act::Look),
    ]
}

fn pause() -> impl Strategy<Value = u64> {
    prop_oneof![6 => 0..30_000u64, 1 => 0..3_000_000u64]
}

/// A wire of the model: when it is to end, when it was told to, and when it was off.
#[derive(Clone, Copy, Debug)]
struct Wire {
    until: u64,
    asked: Option<u64>,
    off: Option<u64>,
}

proptest! {
    /// Against a model of when each wire is off: what is booked of a burst is its time until then, no more and no less,
    /// and the longest time is the guard's.
    #[test]
    fn what_was_on_is_booked_whatever_comes_late_or_fails(
        rounds in prop::collection::vec(
            (
                [1_000..48_000u64, 1_000..48_000],
                [1..100u16, 1..100],
                prop::collection::vec((pause(), act()), 0..8),
                pause(),
            ),
            1..6,
        ),
    ) {
        let clock = crate::units::Clock::external(25_000_000, 100).unwrap();
        let wide_open = Limits { wire_1s_uw: 45_000, ..HARD };
        let mut guard = guard_of(wide_open, Prescale::new(30).with_clock(clock));
        let bus = guard.plant.switching().as_micros();
        let longest = guard.longest().as_micros();
        let (mut now, mut worst) = (0, 0);
        for (lengths, widths, acts, last) in rounds {
            now += 20_000_000; // all that was spent has come back
            let start = now;
            let asked = [0, 1].map(|w| stimulus(w as u16, widths[w], start, lengths[w]));
            let mut entries = vec![];
            let update = guard.admit(us(start), Board(0), &asked, |e| entries.push(e));
            guard.confirm(&update, us(start));
            let mut wires = [0, 1].map(|w: usize| Wire {
                until: entries[w].until.as_micros(),
                asked: None,
                off: None,
            });
            for (pause, act) in acts.into_iter().chain([(last, Act::AskOff)]) {
                now += pause;
                match act {
                    Act::Expire(late) => {
                        let update = guard.expire(us(now), Board(0));
                        let told = now;
                        now += late.unwrap_or(0);
                        for wire in wires.iter_mut().filter(|w| w.until <= told && w.asked.is_none()) {
                            wire.asked = Some(told);
                            wire.off = late.map(|_| now);
                        }
                        if late.is_some() {
                            guard.confirm(&update, us(now));
                        }
                    }
                    Act::AskOff => {
                        guard.ask_off(us(now));
                        let on = wires.iter_mut().filter(|w| w.asked.is_none());
                        on.for_each(|w| w.asked = Some(now));
                    }
                    Act::StillOn => guard.still_on(us(now)),
                    Act::Look => {
                        guard.hear(us(now));
                        // What flowed for seconds before may leave a wire nothing.
                        let mut driven = wires.iter().zip(&entries).filter(|(_, e)| e.width() > Ticks::ZERO);
                        let told = driven.any(|(w, _)| w.asked.is_some() && w.off.is_none());
                        let over = told && now - start > longest;
                        let looked = guard.watch(us(now)) == Some(Cause::Overrun);
                        prop_assert_eq!(looked, over);
                    }
                }
            }
            now += last;
            guard.all_off(us(now));
            for (index, wire) in wires.iter().enumerate() {
                let off = wire.off.unwrap_or(now);
                if entries[index].width() == Ticks::ZERO {
                    continue;
                }
                let booked = wire.until.max(wire.asked.unwrap()).max(off - bus.min(off));
                let span = us(booked).since(us(start));
                let energy = guard.plant.energy_nj(entries[index].width().get(), span);
                prop_assert_eq!(spent(&guard, index), energy, "{:?}", wires);
                worst = worst.max(off - start);
            }
            let found = guard.overrun().map(|found| found.on.as_micros());
            prop_assert_eq!(found, (worst > longest).then_some(worst));
        }
    }
}
