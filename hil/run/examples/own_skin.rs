//! A skin of one's own on the emulated thimble: 6 x 10 capacitive taxels that no board carries. A finger strokes
//! across them, readings are pushed at 50 Hz, and the felt places are printed.

#![allow(clippy::print_stdout)] // a program for a terminal

use std::error::Error;

use palpate_core::skin::ModuleScan;
use palpate_core::units::{Duration, Instant};
use palpate_files::{LayoutFile, Loaded, Setup, Source};
use palpate_records::trace::event;
use palpate_run::EmulatedSession;

const LAYOUT: &str = r#"
kind = "sensor"
name = "palm"
description = "Sixty taxels of one axis in a single module"
axes = 1

[[modules]]
name = "palm"
grid = { rows = 6, columns = 10, pitch_mm = 4.0 }
"#;

fn main() -> Result<(), Box<dyn Error>> {
    let mut setup = Setup::load("idle", "emulated")?;
    let source = Source::new("palm.toml", LAYOUT.to_owned());
    let LayoutFile::Sensor(value) = LayoutFile::read(&source)? else {
        return Err("expected a sensor layout".into());
    };
    setup.sensor = Loaded { value, source };
    let mut session = EmulatedSession::fed(&setup, 1)?;
    session.start(Instant::ZERO)?;

    let mut counts = [[0; 3]; 60];
    for scan in 0..200_u32 {
        let now = Instant::from_micros(u64::from(scan) * 20_000);
        let column = (scan as f32 - 80.0) * 0.08; // reaches the skin after 1.6 s
        for (taxel, reading) in counts.iter_mut().enumerate() {
            let (row, col) = ((taxel / 10) as f32, (taxel % 10) as f32);
            let away = (col - column).powi(2) + (row - 2.5).powi(2);
            let flicker = (scan as u16 + taxel as u16) % 3;
            reading[2] = 100 + flicker + (120.0 * (-away).exp()) as u16;
        }
        session.push(&ModuleScan::whole(0, now, &counts))?;
        session.advance(now + Duration::from_millis(20))?;
    }
    let (events, _) = session.drain();
    for onset in event::each::<event::Felt>(&events) {
        let (t_us, aimed, felt) = (onset.t_us, onset.target, onset.met.map(|m| m.energy));
        println!("{t_us} us: aimed at {aimed:?}, felt at {felt:?} (um)");
    }
    Ok(())
}
