//! Tests of `pass.rs` and `hot.rs`: who is heated when, what waits, and what a refusal does.

use alloc::vec::Vec;
use core::convert::Infallible;

use super::*;
use crate::driver::Actuators;
use crate::guard::{Guarded, Limits, Plant};
use crate::illusion::{Display, DisplayWire, ModelSettings, TimingLaw, build};
use crate::projector::{Cause, Observer, Output, Target};
use crate::units::{Board, Channel, Point};

/// Boards that take everything.
struct Boards;

impl Actuators for Boards {
    type Error = Infallible;

    fn apply(&mut self, _update: &Guarded) -> Result<(), Infallible> {
        Ok(())
    }

    fn all_off(&mut self) -> Result<(), Infallible> {
        Ok(())
    }
}

/// Starts of the stimuli that were passed, in ms, with their channels.
#[derive(Default)]
struct Told(Vec<(u64, u8)>);

impl Observer for Told {
    fn entry(&mut self, entry: &Entry) {
        if entry.width() > Ticks::ZERO {
            self.0.push((entry.at.as_micros() / 1000, entry.channel.0));
        }
    }
}

const TOUCH: Target = Target {
    place: Point::new(5.0, 0.0),
    weight: 1.0,
};

const PASS: HotPass = HotPass {
    width: Ticks::new(100),
    burst: Duration::from_micros(12_700),
    bursts: 1,
    again: Duration::from_millis(250),
    apart: Duration::from_millis(1000),
};

fn output(limits: Limits) -> Output {
    let wire = |n: u8| DisplayWire {
        place: Point::new(10.0 * f32::from(n), 0.0),
        board: Board(0),
        channel: Channel(n),
    };
    let display = Display::new(&[wire(0), wire(1), wire(2)]).unwrap();
    let law = build(&display, &ModelSettings::default()).unwrap();
    let timing = TimingLaw::default().timing(None, Some(Duration::from_millis(100)));
    let builder = Output::builder(display).plant(Plant::default());
    let builder = builder.limits(limits);
    builder.illusion(law, timing.unwrap()).build().unwrap()
}

/// Plays an output for `ms`, with a contact wherever `touched` says.
fn play(output: &mut Output, ms: u64, touched: impl Fn(u64) -> bool) -> Vec<(u64, u8)> {
    let mut told = Told::default();
    for now in 0..ms {
        let at = Instant::from_micros(now * 1000);
        output.hear(at);
        let targets: &[Target] = if touched(now) { &[TOUCH] } else { &[] };
        output
            .turn(at, targets, None, &mut Boards, &mut told)
            .unwrap();
    }
    told.0
}

#[test]
fn wires_are_heated_one_after_the_other() {
    let mut output = output(crate::guard::HARD);
    output.pass(PASS, Instant::from_micros(450_000));
    assert_eq!(
        play(&mut output, 3000, |_| false),
        [(500, 0), (1500, 1), (2500, 2)]
    );
    let passing = output.passing().unwrap();
    assert!(passing.has_passed() && passing.passed() == 3);
}

#[test]
fn bursts_of_one_wire_follow_one_another_and_then_the_next_wire() {
    let mut output = output(crate::guard::HARD);
    let pass = HotPass { bursts: 2, ..PASS };
    output.pass(pass, Instant::ZERO);
    let all = [0, 300, 1000, 1300, 2000, 2300];
    let wires = [0, 0, 1, 1, 2, 2];
    let expected: Vec<(u64, u8)> = all.into_iter().zip(wires).collect();
    assert_eq!(play(&mut output, 3000, |_| false), expected);
}

#[test]
fn a_pass_waits_for_a_pause_and_a_contact_for_one_burst() {
    let mut output = output(crate::guard::HARD);
    output.pass(PASS, Instant::ZERO);
    // A contact from 0.95 to 1.25 s, over the time of the second wire.
    let touched = |ms: u64| (950..1250).contains(&ms);
    let told = play(&mut output, 3500, touched);
    let alone = |t: &&(u64, u8)| !(950..1250).contains(&t.0);
    let heated: Vec<_> = told.iter().filter(alone).copied().collect();
    assert_eq!(heated, [(0, 0), (1300, 1), (2300, 2)]);
    assert!(told.contains(&(1000, 0)) && told.contains(&(1200, 0)));
}

#[test]
fn a_burst_that_outlasts_an_onset_moves_no_other_onset() {
    let mut output = output(crate::guard::HARD);
    let pass = HotPass {
        burst: Duration::from_millis(30),
        ..PASS
    };
    output.pass(pass, Instant::ZERO);
    let told = play(&mut output, 250, |ms| ms >= 50);
    assert_eq!(told[0], (0, 0));
    assert!(told[1..].iter().all(|(ms, _)| ms % 100 == 0));
}

#[test]
fn what_the_guard_refuses_is_no_pass() {
    let limits = Limits {
        burst_energy_nj: 100_000,
        ..crate::guard::HARD
    };
    let mut output = output(limits);
    output.pass(HotPass { bursts: 3, ..PASS }, Instant::ZERO);
    play(&mut output, 3500, |_| false);
    let passing = output.passing().unwrap();
    assert!(passing.is_over() && !passing.has_passed());
    assert_eq!(passing.passed(), 0);
    let (wire, entry) = passing.refused().unwrap();
    assert_eq!(*wire, 0);
    assert!(entry.width() < entry.requested && entry.reason.is_some());
}

#[test]
fn nothing_is_heated_while_everything_is_off() {
    let mut output = output(crate::guard::HARD);
    output.pass(PASS, Instant::ZERO);
    output
        .all_off::<Guarded, _>(Instant::ZERO, Cause::SensorError, &mut Boards, &mut ())
        .unwrap();
    assert_eq!(play(&mut output, 500, |_| false), []);
    assert_eq!(output.passing().unwrap().wires(), 0);
}
