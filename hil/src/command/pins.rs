//! `hil diff SCHEDULE CAPTURE`: what a logic analyser saw of the pins, held against the schedule.

use std::path::Path;

use palpate_records::schedule::read_schedule;

use super::schedules::{damaged, read_log, wires};
use crate::capture::{self, Measurement};
use crate::cli::DiffArgs;
use crate::output::{note, print};
use palpate_run::Failure;

/// Whether the second of two files is a capture, by their names: beside anything but a schedule a CSV is one of
/// contacts.
pub(super) fn is_capture(a: &Path, b: &Path) -> bool {
    let ends = |path: &Path, ending: &str| path.extension().is_some_and(|e| e == ending);
    ends(b, "vcd") || (ends(b, "csv") && ends(a, "jsonl"))
}

/// Compares; `args.b` is the capture.
///
/// # Errors
/// [`Failure::Input`] for a file of another kind, [`Failure::Check`] where a measurement is outside its limits.
pub(super) fn pins(args: &DiffArgs) -> Result<(), Failure> {
    let label = args.a.display().to_string();
    let text = read_log(&args.a, "a schedule (.jsonl)")?;
    let trace = read_schedule(&text, wires).map_err(|damage| damaged(&label, damage))?;
    let seen = capture::read(&args.b)?;
    let found = capture::compare(&trace, &seen, &args.pin)?;
    let bad = found.measurements.iter().filter(|m| !m.good()).count();
    if args.json {
        print(|out| {
            serde_json::to_writer(&mut *out, &found)?;
            writeln!(out)
        })?;
    } else if !args.quiet {
        found.notes.iter().for_each(|text| note(text));
        print(|out| {
            writeln!(
                out,
                "{}: {} bursts, {} pulses, from {:.3} s of the run; {bad} of {} measurements outside their limits",
                trace.header.scene,
                found.bursts,
                found.pulses,
                found.offset_s,
                found.measurements.len()
            )?;
            let worst_first = |m: &&Measurement| m.good();
            let mut sorted: Vec<&Measurement> = found.measurements.iter().collect();
            sorted.sort_by_key(worst_first);
            sorted.iter().try_for_each(|m| {
                let value = m.value.map_or("-".into(), |v| format!("{v:.3}"));
                let mark = if m.good() { "" } else { "  OUTSIDE" };
                writeln!(
                    out,
                    "  {:<42}{value:>10} {:<3} {:.3} to {:.3}{mark}",
                    m.name, m.unit, m.low, m.high
                )
            })
        })?;
    }
    match bad {
        0 => Ok(()),
        _ => Err(Failure::Check(String::new())),
    }
}
