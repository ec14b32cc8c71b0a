//! The files that `hil run` writes: which, checked before it begins, and how.

use std::io;
use std::path::{Path, PathBuf};

use palpate_files::{Format, Setup};
use palpate_records::contacts_csv::write_table;
use palpate_records::json::write_json_lines;
use palpate_records::mcap::{BusTraffic, write_mcap};
use palpate_records::schedule::write_schedule;
use palpate_records::story::schedule_golden;
use palpate_records::vcd::write_vcd;
use palpate_records::wav::write_wav;
use palpate_run::{Failure, Outcome, attachments};

use super::report::{hand, report};
use crate::cli::RunArgs;
use palpate_live::output::{Outputs, check_folder, write_file, write_sidecar, write_text};
use palpate_live::record::path_of;
use palpate_live::recording::write_can_log;

/// The format that `--record` writes under this name.
///
/// # Errors
/// [`Failure::Input`] for a name that ends otherwise.
pub(super) fn format_of_record(path: &Path) -> Result<Format, Failure> {
    Format::of_name(path)
        .filter(|format| !matches!(format, Format::Html | Format::Json))
        .ok_or_else(|| {
            Failure::Input(format!(
                "--record {}: expected a name that ends in .csv (contacts), .jsonl (schedule), .log (candump), .mcap (everything), .vcd (pins, ticks, temperatures) or .snap (golden)",
                path.display()
            ))
        })
}

/// The files that a record under this name makes.
pub(super) fn paths(format: Format, path: &Path, setup: &Setup) -> Vec<PathBuf> {
    let whole = || path.to_owned();
    let each = setup.fingers.iter().map(|f| path_of(path, &f.name));
    match format {
        _ if setup.fingers.is_empty() || !format.is_per_display() => vec![whole()],
        // The hand's page stands before those of its fingers.
        Format::Html => std::iter::once(whole()).chain(each).collect(),
        _ => each.collect(),
    }
}

/// Checks that every file of a record may be written.
///
/// # Errors
/// [`Failure::Input`] for the first that holds something else.
pub(super) fn check(
    outputs: Outputs<'_>,
    (format, path): (Format, &Path),
    setup: &Setup,
) -> Result<(), Failure> {
    if format == Format::Contacts {
        return outputs.check_table(path);
    }
    let mut each = paths(format, path, setup).into_iter();
    each.try_for_each(|path| outputs.check(&path, format))
}

/// Writes a record of a run that is over.
///
/// # Errors
/// [`Failure::Write`] for a file that cannot be written.
pub(super) fn write(
    format: Format,
    path: &Path,
    setup: &Setup,
    outcome: &Outcome,
) -> Result<(), Failure> {
    if !format.is_per_display() || outcome.displays.is_empty() {
        return write_one(format, path, setup, outcome);
    }
    let mut paths = paths(format, path, setup);
    if format == Format::Html {
        let whole = paths.remove(0);
        write_text(&whole, &hand(setup, outcome, &paths))?;
    }
    let mut each = paths.iter().zip(&outcome.displays);
    each.try_for_each(|(path, display)| write_one(format, path, setup, &display.outcome))
}

fn write_one(format: Format, path: &Path, setup: &Setup, outcome: &Outcome) -> Result<(), Failure> {
    write_file(path, |out| match format {
        Format::Contacts => write_table(&outcome.trace, out),
        Format::Mcap => {
            let traffic = BusTraffic {
                can: &outcome.can,
                i2c: &outcome.i2c,
                ..BusTraffic::default()
            };
            let run = (&outcome.trace, outcome.readings.as_ref());
            write_mcap(run, traffic, &attachments(setup), out)
        }
        Format::Vcd => write_vcd(&outcome.trace, out),
        Format::Wav => match &outcome.sound {
            Some(sound) => write_wav(sound.rate_hz, sound.channels, &sound.samples, out),
            None => Err(io::Error::other("no sound card played")),
        },
        Format::Schedule => write_schedule(&outcome.trace, out),
        Format::Candump => write_can_log(&outcome.can, &[], out),
        Format::Golden => out.write_all(schedule_golden(&outcome.trace).as_bytes()),
        Format::Html => out.write_all(report(outcome).as_bytes()),
        Format::Json => {
            write_json_lines(&outcome.summary, &mut *out)?;
            writeln!(out)
        }
        other => Err(io::Error::other(format!("{} is no record", other.noun()))),
    })?;
    match format {
        Format::Contacts => write_sidecar(path, Some(&outcome.trace.header)),
        _ => Ok(()),
    }
}

/// The outputs of a run: which files they may replace.
pub(super) fn outputs(args: &RunArgs) -> Outputs<'_> {
    Outputs {
        force: args.force,
        inputs: &args.replay,
    }
}

/// The files to write, checked before anything runs.
pub(super) fn wanted(args: &RunArgs, setup: &Setup) -> Result<Vec<(Format, PathBuf)>, Failure> {
    let mut files = Vec::new();
    if let Some(folder) = &args.out {
        check_folder(folder)?;
        for (format, name) in [
            (Format::Json, "summary.json"),
            (Format::Schedule, "schedule.jsonl"),
            (Format::Contacts, "contacts.csv"),
            (Format::Html, "report.html"),
        ] {
            files.push((format, folder.join(name)));
        }
    }
    files.extend(args.schedule.iter().map(|p| (Format::Schedule, p.clone())));
    files.extend(args.html.iter().map(|p| (Format::Html, p.clone())));
    if let Some(path) = &args.wav {
        let haptics = setup.bench.value.haptics.as_ref();
        if haptics.is_none_or(|haptics| haptics.audio.is_none()) {
            return Err(Failure::Input(format!(
                "--wav: expected a bench with voice coils on a sound card, such as `voice-coil-8`, found `{}`",
                setup.bench.value.name
            )));
        }
        files.push((Format::Wav, path.clone()));
    }
    for path in &args.record {
        files.push((format_of_record(path)?, path.clone()));
    }
    let outputs = outputs(args);
    for (n, (format, path)) in files.iter().enumerate() {
        check(outputs, (*format, path), setup)?;
        if files[..n].iter().any(|(_, before)| before == path) {
            return Err(Failure::Input(format!(
                "{}: expected one output per file, found two",
                path.display()
            )));
        }
    }
    outputs.check_some(args.junit.as_deref(), Format::Junit)?;
    Ok(files)
}
