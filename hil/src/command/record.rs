//! `hil record` and `hil replay`: live buses to a recording, a recording onto buses.

use std::path::PathBuf;

use palpate_core::units::Duration;
use palpate_files::{Format, USUAL_BITRATE, load_skin};

use crate::cli::{RecordArgs, ReplayArgs};
use palpate_live::output::{Outputs, list_written, note};
use palpate_live::record;
use palpate_live::recording::read_can_recording;
use palpate_run::Failure;

/// Records interfaces until stopped.
///
/// # Errors
/// [`Failure`] with its exit status.
pub fn record(args: &RecordArgs) -> Result<(), Failure> {
    let format = |path: &PathBuf| match Format::of_name(path) {
        Some(format @ (Format::Candump | Format::Mcap)) => Ok((format, path.clone())),
        _ => Err(Failure::Input(format!(
            "{}: expected a name that ends in .log (candump) or .mcap",
            path.display()
        ))),
    };
    let files: Vec<_> = args.files.iter().map(format).collect::<Result<_, _>>()?;
    let outputs = Outputs::new(args.force);
    for (format, path) in &files {
        outputs.check(path, *format)?;
    }
    let length = args
        .seconds
        .map(|s| Duration::from_micros((s * 1e6).round() as u64));
    if !args.voice.quiet {
        note(&format!("recording {}; Ctrl-C stops", args.can.join(", ")));
    }
    let recorded = record::record(&args.can, &files, length, outputs)?;
    if !(args.voice.json || args.voice.quiet) {
        recorded.notes.iter().for_each(|text| note(text));
    }
    args.voice.tell(
        || &recorded,
        |out| {
            writeln!(
                out,
                "{} frames in {:.3} s (real), {} not recorded",
                recorded.frames,
                recorded.length_ms as f64 * 1e-3,
                recorded.frames_not_recorded
            )?;
            for can in &recorded.can {
                writeln!(out, "  {:<16}{}", can.interface, can.words())?;
            }
            list_written(files.iter().map(|(_, path)| path), out)
        },
    )
}

/// Plays a recording onto interfaces.
///
/// # Errors
/// [`Failure`] with its exit status.
pub fn replay(args: &ReplayArgs) -> Result<(), Failure> {
    let skin = args.layout.as_deref().map(load_skin).transpose()?;
    let bitrate = skin.map_or(USUAL_BITRATE, |skin| skin.value.bitrate);
    let recording = read_can_recording(&args.file, (args.can.len(), bitrate), args.split_jumps)?;
    recording.notes.iter().for_each(|text| note(text));
    let played = record::play(&recording, &args.can)?;
    args.voice.tell(
        || &played,
        |out| {
            writeln!(
                out,
                "{} frames sent in {:.3} s, {} lost, {} left; late by {} us median, {} us at most",
                played.sent,
                played.length_ms as f64 * 1e-3,
                played.lost,
                played.left,
                played.late_median_us,
                played.late_worst_us
            )
        },
    )
}
