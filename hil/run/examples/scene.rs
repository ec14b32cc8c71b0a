//! A scene run from Rust, with its temperatures read: when wires and tissue were hottest, and what is left of every
//! limit.

#![allow(clippy::print_stdout)] // a program for a terminal

use std::error::Error;

use palpate_files::Setup;
use palpate_run::{Input, run};

fn main() -> Result<(), Box<dyn Error>> {
    let setup = Setup::load("two-finger-press", "thesis")?;
    let outcome = run(&setup, &Input::Scene, 1)?;
    let hottest = |of: fn(&palpate_records::report::Warmth) -> f64| {
        let times = outcome.warmth.iter().map(|w| (w.t_s, of(w)));
        times.max_by(|a, b| a.1.total_cmp(&b.1)).unwrap_or_default()
    };
    let (t_s, wire_c) = hottest(|w| w.wire_c);
    println!("hottest wire:   {wire_c:.1} C at {t_s:.2} s");
    let (t_s, tissue_c) = hottest(|w| w.shallow_c);
    println!("hottest tissue: {tissue_c:.1} C at {t_s:.2} s, 0.1 mm deep");
    for margin in &outcome.trace.ledger.margins {
        let (name, unit) = (margin.of.name(), margin.of.unit());
        println!(
            "{name:<26} {:>9.3} of {:>8.3} {unit}",
            margin.worst(),
            margin.limit()
        );
    }
    Ok(())
}
