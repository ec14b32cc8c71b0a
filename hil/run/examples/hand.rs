//! A session of one's own under a hand: a finger presses the skin while the loop runs, and the felt places are printed.

#![allow(clippy::print_stdout)] // a program for a terminal

use std::error::Error;

use palpate_core::units::Instant;
use palpate_files::Setup;
use palpate_records::trace::event;
use palpate_run::{EmulatedSession, press};

fn main() -> Result<(), Box<dyn Error>> {
    let setup = Setup::load("idle", "emulated")?;
    let (mut session, hands) = EmulatedSession::touched(&setup, 1)?;
    session.start(Instant::ZERO)?;
    session.advance(Instant::from_micros(1_000_000))?; // the skin at rest
    hands[0].press(&[press(1.0, -2.0, 0.8, 10.0)]); // mm, mm, N, mm
    session.advance(Instant::from_micros(1_500_000))?;
    let (events, _) = session.drain();
    for onset in event::each::<event::Felt>(&events) {
        let (t_us, felt) = (onset.t_us, onset.met.map(|met| met.energy));
        println!("{t_us} us: felt at {felt:?} (um)");
    }
    Ok(())
}
