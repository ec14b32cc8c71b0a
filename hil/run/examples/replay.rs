//! A replay from an array: rows of raw counts, one per 10 ms, through the loop onto the emulated display.

#![allow(clippy::print_stdout)] // a program for a terminal

use std::error::Error;

use palpate_files::{Overrides, Setup, load_bench, load_scene};
use palpate_run::{Input, TaxelTable, run};

fn main() -> Result<(), Box<dyn Error>> {
    let (taxels, rows) = (16, 300);
    // A press on taxel 5 from the hundredth row on; a flicker of one count everywhere.
    let row = |row: usize| {
        (0..taxels).flat_map(move |taxel| {
            let pressed = if row >= 100 && taxel == 5 { 600 } else { 0 };
            [
                30_000,
                30_000,
                30_000 + pressed + ((row + taxel) % 2) as u16,
            ]
        })
    };
    let table = TaxelTable {
        time_us: (0..rows).map(|row| row as u64 * 10_000).collect(),
        counts: (0..rows).flat_map(row).collect(),
        columns: 3 * taxels,
    };
    let mut change = Overrides::default();
    change.scene("example", "layout", "uskin-4x4");
    let scene = load_scene("idle")?.with(&change)?;
    let setup = Setup::join(scene, load_bench("emulated")?)?;
    let outcome = run(&setup, &Input::tables(vec![table]), 1)?;
    let summary = &outcome.summary;
    println!("{} contacts in {} frames", summary.contacts, summary.frames);
    println!(
        "{} stimuli, {} limited",
        summary.stimuli, summary.limiter_events
    );
    Ok(())
}
