//! `hil serve`: a scene that runs, or recordings, in pages.

use std::os::fd::AsFd;
use std::path::{Path, PathBuf};

use palpate_buses::served::wait::{Signals, monotonic_ns, wait};
use palpate_files::{FileError, Format, format_of};
use palpate_run::Failure;

use super::run;
use crate::cli::{Color, RunArgs, ServeArgs};
use palpate_live::output::note;
use palpate_live::serve::Recordings;

/// Longest wait for a signal at a time.
const HOUR_NS: u64 = 3_600_000_000_000;

/// Runs a scene with its page, or shows one or two recordings until a signal comes.
///
/// # Errors
/// [`Failure`] with its exit status.
pub fn serve(args: ServeArgs, color: Color) -> Result<(), Failure> {
    let recordings = recordings(&args.what)?;
    if recordings.is_empty() {
        return run(&RunArgs::from(args), color);
    }
    let on = &args.on;
    if on.bench.is_some() || !on.can.is_empty() || !on.i2c.is_empty() {
        return Err(Failure::Input(format!(
            "{}: expected neither --bench nor --can nor --i2c with a recording, which has its bench with it",
            args.what[0]
        )));
    }
    let shown = Recordings::read(&recordings)?;
    let signals = |e| Failure::Device(format!("signals: {e}"));
    // Before there are other threads, which would be ended by them.
    let mut stop = Signals::catch().map_err(signals)?;
    let url = shown.serve(args.at)?;
    note(&format!("{}: {url}; Ctrl-C ends it", args.what.join(", ")));
    shown.damages().iter().for_each(|text| note(text));
    while !stop.raised() {
        wait(&[stop.as_fd()], monotonic_ns() + HOUR_NS).map_err(signals)?;
    }
    Ok(())
}

/// The recordings among what is to be served; none where that is a scene.
fn recordings(what: &[String]) -> Result<Vec<PathBuf>, Failure> {
    let mut recordings = Vec::new();
    for name in what {
        let path = Path::new(name);
        let named = path
            .extension()
            .is_some_and(|e| e.eq_ignore_ascii_case("mcap"));
        match format_of(path) {
            Some(Format::Mcap) => recordings.push(path.to_path_buf()),
            Some(Format::Toml) | None if !named => {}
            Some(format) => {
                let expected = "a scene (TOML) or a recording of a run (.mcap)";
                return Err(FileError::whole(name, expected, format.noun()).into());
            }
            None => recordings.push(path.to_path_buf()),
        }
    }
    match what {
        [_, other] if recordings.len() != 2 => {
            let expected = "one scene, or one or two recordings (.mcap) to show beside each other";
            Err(FileError::whole(other, expected, "a scene among two").into())
        }
        _ => Ok(recordings),
    }
}
