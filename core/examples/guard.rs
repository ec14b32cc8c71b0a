//! The guard alone, before a driver of one's own: what it passes, clamps and refuses of one wire that is asked for too much.

#![allow(clippy::print_stdout)] // its output is the point

use std::error::Error;

use palpate_core::guard::{Guard, HARD, Plant, WornWire};
use palpate_core::illusion::DisplayWire;
use palpate_core::schedule::Stimulus;
use palpate_core::units::{Board, Channel, Duration, Instant, Milliamps, Point, Ticks};

fn main() -> Result<(), Box<dyn Error>> {
    let wire = DisplayWire {
        place: Point::new(0.0, 0.0),
        board: Board(0),
        channel: Channel(3),
    };
    let mut guard = Guard::new(HARD, Plant::default(), &[wire], WornWire::default())?;
    for onset in 0..12 {
        let at = Instant::from_micros(58_500 * onset);
        guard.hear(at); // a sensor frame: a skin that falls silent stops the wires
        let asked = Stimulus {
            wire: 0,
            width: Ticks::new(4095), // of 4096: far beyond the table
            peak: Milliamps(1970),
            at,
            until: at + Duration::from_millis(35),
        };
        let update = guard.admit(at, Board(0), &[asked], |entry| {
            println!(
                "{:>4} ms  asked {}, applied {} of 4096  {:?}",
                at.as_micros() / 1000,
                entry.requested.get(),
                entry.width().get(),
                entry.reason
            );
        });
        // Here a driver writes what passed, and says when it stands.
        guard.confirm(&update, at);
        let end = guard.expire(asked.until, Board(0));
        guard.confirm(&end, asked.until);
    }
    Ok(())
}
