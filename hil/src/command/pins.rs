//! `hil diff SCHEDULE CAPTURE`: what a logic analyser saw of the pins, held against the schedule.

use std::io::{self, Write};
use std::path::Path;

use palpate_records::schedule::read_schedule;
use palpate_records::verdict::Verdict;

use super::schedules::{read_log, wires};
use crate::cli::{Color, DiffArgs};
use palpate_capture::{Comparison, Measurement};
use palpate_files::{Format, LONGEST_LINE, Lines, format_of};
use palpate_live::output::{note, print, print_json};
use palpate_live::progress::Progress;
use palpate_run::{Failure, damaged};

/// Tells whether the second of two files is a capture, by its first bytes or its name. A CSV is one beside a schedule, and contacts
/// beside anything else.
pub(super) fn is_capture(a: &Path, b: &Path) -> bool {
    let ends = |path: &Path, ending: &str| path.extension().is_some_and(|e| e == ending);
    let is_dump = matches!(format_of(b), Some(Format::Vcd | Format::Fst | Format::Ghw));
    let is_beside_contacts = ends(a, "csv");
    (is_dump && !is_beside_contacts)
        || ends(b, "vcd")
        || ends(b, "fst")
        || ends(b, "ghw")
        || (ends(b, "csv") && ends(a, "jsonl"))
}

/// Compares; `args.b` is the capture. The first line says the verdict.
///
/// # Errors
/// [`Failure::Input`] for a file of another kind, [`Failure::Check`] where a measurement is outside its limits or
/// the capture lacks something that was planned.
pub(super) fn pins(args: &DiffArgs, color: Color) -> Result<(), Failure> {
    let label = args.a.display().to_string();
    let lines = Lines::open(&args.a, "a schedule (.jsonl)", LONGEST_LINE)?;
    let text = read_log(lines)?;
    let trace = read_schedule(&text, wires).map_err(|damage| damaged(label, damage))?;
    let shown = Progress::reading(&args.b);
    let seen = palpate_capture::read(&args.b)?;
    drop(shown);
    let found = palpate_capture::compare(&trace, &seen, &args.pin, args.window)?;
    if args.json {
        print_json(&found)?;
    } else if !args.quiet {
        found.notes.iter().for_each(|text| note(text));
        let colored = color.on(&io::stdout());
        print(|out| write(&trace.header.scene, &found, colored, out))?;
    }
    match found.conclusion.verdict {
        Verdict::Ok => Ok(()),
        _ => Err(Failure::Check(String::new())),
    }
}

/// Verdict and reasons, coverage, then the measurements, those outside their limits first.
fn write(scene: &str, found: &Comparison, colored: bool, out: &mut dyn Write) -> io::Result<()> {
    found.conclusion.write(out, colored)?;
    let coverage = &found.coverage;
    let begins = found.offset_s.map_or_else(String::new, |s| {
        let rounded = (s * 1e3).round() / 1e3 + 0.0; // no minus before a zero
        format!(", the capture begins at {rounded:.3} s of the run")
    });
    writeln!(
        out,
        "{scene}: {} of {} bursts, {} of {} channels, {:.2} of {:.2} s seen; {} pulses{begins}",
        coverage.bursts_seen,
        coverage.bursts_planned,
        coverage.channels_seen,
        coverage.channels_planned,
        coverage.seconds_seen,
        coverage.seconds_planned,
        found.pulses
    )?;
    let mut sorted: Vec<&Measurement> = found.measurements.iter().collect();
    sorted.sort_by_key(|m| m.good());
    sorted.iter().try_for_each(|m| {
        let value = m.value.map_or("-".into(), |v| format!("{v:.3}"));
        let mark = if m.good() { "" } else { "  OUTSIDE" };
        writeln!(
            out,
            "  {:<42}{value:>10} {:<3} {:.3} to {:.3}{mark}",
            m.name, m.unit, m.low, m.high
        )
    })
}
