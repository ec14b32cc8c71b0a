//! The output half alone: a point that is felt to move from one wire to the next, with targets from code.
//!
//! Prints what the guard lets through. A driver such as `Pca9685Bank` would stand in the place of `Paper`.

#![allow(clippy::print_stdout)] // its output is the point

use core::convert::Infallible;
use std::error::Error;

use palpate_core::driver::Actuators;
use palpate_core::guard::Guarded;
use palpate_core::illusion::{Display, DisplayWire, Target};
use palpate_core::projector::{Cause, Output};
use palpate_core::units::{Board, Channel, Instant, Point};

/// A board on paper.
struct Paper;

impl Actuators for Paper {
    type Error = Infallible;

    fn apply(&mut self, update: &Guarded) -> Result<(), Infallible> {
        let time = update.at().as_micros() / 1000;
        let channels = update.channels().iter().enumerate();
        for (channel, setting) in channels.filter_map(|(n, s)| Some((n, (*s)?))) {
            let ticks = setting.off - setting.on;
            println!("{time:>4} ms  channel {channel}  {ticks:>3} of 4096");
        }
        Ok(())
    }

    fn all_off(&mut self) -> Result<(), Infallible> {
        println!("all off");
        Ok(())
    }
}

fn main() -> Result<(), Box<dyn Error>> {
    let wire = |n: u8| DisplayWire {
        place: Point::new(10.0 * f32::from(n), 0.0),
        board: Board(0),
        channel: Channel(n),
    };
    let mut output = Output::builder(Display::new(&[wire(0), wire(1)])?).build()?;
    let (mut now, end) = (Instant::ZERO, Instant::from_micros(1_000_000));
    while now < end {
        let seconds = now.as_micros() as f32 * 1e-6;
        let point = Target {
            place: Point::new(10.0 * seconds, 0.0), // a centimetre per second
            weight: 1.0,
        };
        output.hear(now); // the target is alive
        output.turn(now, &[point], None, &mut Paper, &mut ())?;
        now = output.next();
    }
    output.all_off(end, Cause::End, &mut Paper, &mut ())?;
    Ok(())
}
