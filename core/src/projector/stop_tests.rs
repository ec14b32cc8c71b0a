//! Tests of `stop.rs`: what is told and latched when everything goes off, in time, late, or not at all.

use alloc::vec;
use alloc::vec::Vec;

use super::*;
use crate::guard::{Guarded, Plant};
use crate::illusion::{Display, DisplayWire, ModelSettings, Target, TimingLaw, build};
use crate::schedule::{Entry, Reason, Timing};
use crate::units::{Channel, Duration, Point};

/// The call that failed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{0}")]
struct Failed(&'static str);

/// Boards that answer late, or not; and how often they were asked.
#[derive(Debug, Default)]
struct Boards {
    late_us: u64,
    /// Whether updates and all-offs fail.
    fails: (bool, bool),
    updates: u32,
    offs: u32,
}

impl Actuators for Boards {
    type Error = Failed;

    fn apply(&mut self, _update: &Guarded) -> Result<(), Self::Error> {
        self.updates += 1;
        if self.fails.0 {
            Err(Failed("update"))
        } else {
            Ok(())
        }
    }

    fn all_off(&mut self) -> Result<(), Self::Error> {
        self.offs += 1;
        if self.fails.1 {
            Err(Failed("all-off"))
        } else {
            Ok(())
        }
    }

    fn confirmed(&self, asked: Instant) -> Instant {
        asked + Duration::from_micros(self.late_us)
    }
}

/// What an observer was told.
#[derive(Debug, Default)]
struct Told {
    offs: Vec<(u64, u8, Cause)>,
    entries: Vec<Entry>,
}

impl Observer for Told {
    fn all_off(&mut self, at: Instant, board: Board, cause: Cause) {
        self.offs.push((at.as_micros(), board.0, cause));
    }

    fn entry(&mut self, entry: &Entry) {
        self.entries.push(*entry);
    }
}

const BETWEEN: Target = Target {
    place: Point::new(5.0, 0.0),
    weight: 1.0,
};

const fn us(us: u64) -> Instant {
    Instant::from_micros(us)
}

fn output() -> Output {
    output_with(TimingLaw::default().timing(None, None).unwrap())
}

fn output_with(timing: Timing) -> Output {
    let wire = |n: u8| DisplayWire {
        place: Point::new(10.0 * f32::from(n), 0.0),
        board: Board(n),
        channel: Channel(0),
    };
    let display = Display::new(&[wire(0), wire(1)]).unwrap();
    let law = build(&display, &ModelSettings::default()).unwrap();
    let builder = Output::builder(display).plant(Plant::default());
    builder.illusion(law, timing).build().unwrap()
}

/// One that has driven both wires, on a board each, for 10 ms; they go on until 35 ms.
fn driving(boards: &mut Boards, told: &mut Told) -> Output {
    let mut output = output();
    for now in [0, 10_000] {
        output.hear(us(now));
        output
            .turn(us(now), &[BETWEEN], None, boards, told)
            .unwrap();
    }
    assert_eq!((boards.updates, boards.offs), (2, 0));
    assert_eq!(output.guard().next_expiry(), Some(us(35_000)));
    output
}

fn each(at: u64, cause: Cause) -> [(u64, u8, Cause); 2] {
    [(at, 0, cause), (at, 1, cause)]
}

#[test]
fn an_all_off_is_told_with_the_time_at_which_it_stands() {
    let (mut boards, mut told) = (Boards::default(), Told::default());
    let mut output = driving(&mut boards, &mut told);
    boards.late_us = 7;
    output
        .all_off(us(20_000), Cause::End, &mut boards, &mut told)
        .unwrap();
    assert_eq!(told.offs, each(20_007, Cause::End));
    assert_eq!(output.guard().latched(), Some(Cause::End));
    assert!(!output.settle(us(90_000), &mut told));
    assert_eq!(told.offs.len(), 2);
    assert_eq!(output.guard().overrun(), None);
}

#[test]
fn what_could_not_be_switched_off_is_told_once_it_is_known_to_be() {
    for (settled, cause) in [(56_521, Cause::ActuatorError), (56_522, Cause::Overrun)] {
        let (mut boards, mut told) = (Boards::default(), Told::default());
        let mut output = driving(&mut boards, &mut told);
        boards.fails = (true, true);
        output.hear(us(35_000));
        let error = output.turn(us(35_000), &[], None, &mut boards, &mut told);
        assert_eq!(error, Err(Failed("update")));
        // Nor is it known after the next try, whose cause does not come first.
        let again = output.all_off(us(40_000), Cause::End, &mut boards, &mut told);
        assert_eq!((again, boards.offs), (Err(Failed("all-off")), 2));
        assert!(told.offs.is_empty());
        assert_eq!(output.guard().latched(), Some(Cause::ActuatorError));
        let overran = output.settle(us(settled), &mut told);
        assert_eq!(overran, cause == Cause::Overrun);
        assert_eq!(told.offs, each(settled, cause));
        assert_eq!(output.guard().latched(), Some(cause));
        assert_eq!(output.guard().overrun().is_some(), overran);
        assert!(!output.guard().overran());
    }
}

#[test]
fn an_all_off_that_succeeds_settles_those_that_failed() {
    let (mut boards, mut told) = (Boards::default(), Told::default());
    let mut output = driving(&mut boards, &mut told);
    boards.fails.1 = true;
    output
        .all_off(us(20_000), Cause::SensorError, &mut boards, &mut told)
        .unwrap_err();
    boards.fails.1 = false;
    output
        .all_off(us(30_000), Cause::End, &mut boards, &mut told)
        .unwrap();
    let mut expected = each(30_000, Cause::SensorError).to_vec();
    expected.extend(each(30_000, Cause::End));
    assert_eq!(told.offs, expected);
}

#[test]
fn an_end_that_arrives_late_stops_for_an_overrun_and_only_the_owner_ends_that() {
    for (late, over) in [(21_521, false), (21_522, true)] {
        let (mut boards, mut told) = (Boards::default(), Told::default());
        let mut output = driving(&mut boards, &mut told);
        boards.late_us = late;
        output.hear(us(35_000));
        output
            .turn(us(35_000), &[BETWEEN], None, &mut boards, &mut told)
            .unwrap();
        assert_eq!(boards.offs, u32::from(over));
        if !over {
            assert!(told.offs.is_empty());
            continue;
        }
        assert_eq!(told.offs, each(35_000 + late, Cause::Overrun));
        assert_eq!(output.guard().latched(), Some(Cause::Overrun));
        // Nothing is driven any more, and nothing is switched off twice.
        boards.late_us = 0;
        output.hear(us(58_500));
        output
            .turn(us(58_500), &[BETWEEN], None, &mut boards, &mut told)
            .unwrap();
        assert_eq!(told.entries.last().unwrap().reason, Some(Reason::Latched));
        assert_eq!((boards.updates, boards.offs), (4, 1));
        assert_eq!(output.reset(us(58_500), &mut boards, &mut told), Ok(()));
        assert_eq!(output.guard().latched(), None);
        assert!(output.guard().overrun().is_some());
    }
}

#[test]
fn a_wire_that_is_not_known_to_be_off_is_looked_at_until_it_is() {
    let (mut boards, mut told) = (Boards::default(), Told::default());
    let mut output = driving(&mut boards, &mut told);
    boards.fails.1 = true;
    output
        .all_off(us(20_000), Cause::ActuatorError, &mut boards, &mut told)
        .unwrap_err();
    let mut look = |output: &mut Output, boards: &mut Boards, now: u64| {
        output.hear(us(now));
        output.turn(us(now), &[], None, boards, &mut told)
    };
    assert_eq!(look(&mut output, &mut boards, 56_521), Ok(false));
    assert_eq!(boards.offs, 1);
    for (offs, now) in [(2, 56_522), (3, 57_000)] {
        assert_eq!(look(&mut output, &mut boards, now), Err(Failed("all-off")));
        assert_eq!(boards.offs, offs);
        assert_eq!(output.guard().latched(), Some(Cause::Overrun));
    }
    boards.fails.1 = false;
    look(&mut output, &mut boards, 57_500).unwrap();
    look(&mut output, &mut boards, 58_000).unwrap();
    assert_eq!(boards.offs, 4);
    let mut expected = each(57_500, Cause::Overrun).to_vec();
    expected.extend(each(57_500, Cause::Overrun));
    assert_eq!(told.offs, expected);
}

#[test]
fn the_way_back_settles_and_is_none_where_that_came_too_late() {
    for (now, late) in [(40_000, false), (60_000, true)] {
        let (mut boards, mut told) = (Boards::default(), Told::default());
        let mut output = driving(&mut boards, &mut told);
        boards.fails.1 = true;
        output
            .all_off(us(20_000), Cause::ActuatorError, &mut boards, &mut told)
            .unwrap_err();
        output.hear(us(now - 1000));
        let _ = output.turn(us(now - 5000), &[], None, &mut boards, &mut told);
        assert_eq!(
            output.reset(us(now), &mut boards, &mut told),
            Err(Cause::ActuatorError)
        );
        boards.fails.1 = false;
        let back = output.reset(us(now), &mut boards, &mut told);
        assert_eq!(back, if late { Err(Cause::Overrun) } else { Ok(()) });
        let cause = if late {
            Cause::Overrun
        } else {
            Cause::ActuatorError
        };
        assert_eq!(told.offs, each(now, cause));
        assert_eq!(output.guard().latched(), late.then_some(Cause::Overrun));
        // Who asks again has looked.
        assert_eq!(output.reset(us(now), &mut boards, &mut told), Ok(()));
    }
}

#[test]
fn what_is_still_on_is_counted_so() {
    let (mut boards, mut told) = (Boards::default(), Told::default());
    let mut output = driving(&mut boards, &mut told);
    boards.fails.1 = true;
    output
        .all_off(us(20_000), Cause::End, &mut boards, &mut told)
        .unwrap_err();
    output.still_on(us(500_000));
    let on = output.guard().overrun().map(|found| found.on);
    assert_eq!(on, Some(Duration::from_millis(500)));
    assert_eq!(told.offs, vec![]);
}

#[test]
fn a_stimulus_that_is_over_when_its_turn_comes_is_left_out_and_no_overrun() {
    let soa_us = 117_000;
    // What a burst may not be longer than ends the second.
    for (length_us, over_us) in [(38_000, 38_000), (90_000, 50_000)] {
        let [length, soa] = [length_us, soa_us].map(Duration::from_micros);
        let timing = TimingLaw::default().timing(Some(length), Some(soa));
        for late_us in [0, over_us - 1, over_us, soa_us - 1] {
            let (mut boards, mut told) = (Boards::default(), Told::default());
            let mut output = output_with(timing.unwrap());
            let now = us(10 * soa_us + late_us);
            output.hear(now);
            let polled = output.turn(now, &[BETWEEN], None, &mut boards, &mut told);
            assert_eq!(polled, Ok(true));
            let is_driven = late_us < over_us;
            assert_eq!(boards.updates, 2 * u32::from(is_driven), "{late_us}");
            assert_eq!(output.guard().next_expiry().is_some(), is_driven);
            // What is driven ends in its time, the next comes in its own.
            let mut next = output.next();
            if is_driven {
                assert!(next <= us(10 * soa_us + over_us), "{next:?}");
                next = next.max(now);
                output.hear(next);
                let ended = output.turn(next, &[], None, &mut boards, &mut told);
                assert_eq!((ended, boards.updates), (Ok(false), 4));
                next = output.next();
            }
            assert_eq!(next, us(11 * soa_us));
            assert_eq!((output.guard().overrun(), boards.offs), (None, 0));
        }
    }
}
