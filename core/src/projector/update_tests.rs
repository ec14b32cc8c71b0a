//! A stop of the guard that only looks on: told, and nothing else.

use alloc::vec::Vec;
use core::convert::Infallible;

use crate::driver::Actuators;
use crate::guard::{Cause, Observed, Plant};
use crate::illusion::{Display, DisplayWire, ModelSettings, Target, TimingLaw, build};
use crate::projector::{Observer, Output};
use crate::units::{Board, Channel, Instant, Point};

/// Updates written, and all-offs.
#[derive(Default)]
struct Written(Vec<Observed>, u32);

impl Actuators<Observed> for Written {
    type Error = Infallible;

    fn apply(&mut self, update: &Observed) -> Result<(), Infallible> {
        self.0.push(update.clone());
        Ok(())
    }

    fn all_off(&mut self) -> Result<(), Infallible> {
        self.1 += 1;
        Ok(())
    }
}

#[derive(Default)]
struct Stops(Vec<(Instant, Cause)>, u32);

impl Observer for Stops {
    fn observed_stop(&mut self, at: Instant, cause: Cause) {
        self.0.push((at, cause));
    }

    fn all_off(&mut self, _: Instant, _: Board, _: Cause) {
        self.1 += 1;
    }
}

#[test]
fn a_stop_is_told_and_ends_nothing_that_is_driven() {
    let wire = |n: u8| DisplayWire {
        place: Point::new(10.0 * f32::from(n), 0.0),
        board: Board(0),
        channel: Channel(n),
    };
    let display = Display::new(&[wire(0), wire(1)]).unwrap();
    let law = build(&display, &ModelSettings::default()).unwrap();
    let timing = TimingLaw::default().timing(None, None).unwrap();
    let builder = Output::builder(display).plant(Plant::default());
    let mut output = builder.illusion(law, timing).build().unwrap();
    let on_a_wire = Target {
        place: Point::new(0.0, 0.0),
        weight: 1.0,
    };
    let (mut registers, mut stops) = (Written::default(), Stops::default());
    let at = Instant::from_micros;
    let mut turn = |output: &mut Output, now: u64, heard: bool| {
        if heard {
            output.hear(at(now));
        }
        let called = output.turn(at(now), &[on_a_wire], None, &mut registers, &mut stops);
        assert!(called.is_ok());
        (registers.0.len(), registers.1, stops.0.clone(), stops.1)
    };
    // A burst begins, ends, and the next begins; then nothing is heard while it lasts.
    turn(&mut output, 0, true);
    turn(&mut output, 35_000, false);
    assert_eq!(turn(&mut output, 58_500, false).0, 3);
    let stale = (at(90_000), Cause::StaleInput);
    assert_eq!(turn(&mut output, 90_000, false), (3, 0, [stale].into(), 0));
    // Told once, and the loop is not called for a deadline that is past.
    assert_eq!(output.next(), at(93_500));
    assert_eq!(turn(&mut output, 91_000, false).2.len(), 1);
    assert_eq!(output.guard().latched(), Some(Cause::StaleInput));
    // It ends when it was to end, and the guard looks on again once input is heard.
    assert_eq!(turn(&mut output, 93_500, false).0, 4);
    assert_eq!(turn(&mut output, 117_000, true), (5, 0, [stale].into(), 0));
    assert_eq!(output.guard().latched(), None);
}
