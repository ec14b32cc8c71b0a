//! `hil serve`: a scene that runs, or recordings, in pages.

use std::os::fd::AsFd;
use std::path::{Path, PathBuf};

use palpate_buses::served::wait::{Signals, monotonic_ns, wait};
use palpate_files::{FileError, Format, entries, format_of};
use palpate_run::Failure;

use super::run;
use super::served::{browse, openable};
use crate::cli::{Color, RunArgs, ServeArgs};
use palpate_live::output::note;
use palpate_live::serve::Recordings;

/// Most recordings beside each other.
const MOST: usize = 2;
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
    if args.again {
        return Err(Failure::Input(format!(
            "{}: expected no --loop with a recording; its page plays it again",
            args.what[0]
        )));
    }
    openable(args.at, args.open)?;
    let shown = Recordings::read(&recordings)?;
    let signals = |e| Failure::Device(format!("signals: {e}"));
    // Before there are other threads, which would be ended by them.
    let mut stop = Signals::catch().map_err(signals)?;
    let url = shown.serve(args.at)?;
    note(&format!("{}: {url}; Ctrl-C ends it", args.what.join(", ")));
    if args.open {
        browse(&url);
    }
    shown.damages().iter().for_each(|text| note(text));
    while !stop.raised() {
        wait(&[stop.as_fd()], monotonic_ns() + HOUR_NS).map_err(signals)?;
    }
    Ok(())
}

/// The recordings in a folder of `hil run --out`.
fn in_folder(folder: &Path) -> Result<Vec<PathBuf>, FileError> {
    let all = entries(folder)?.into_iter();
    let found: Vec<PathBuf> = all.filter(|p| format_of(p) == Some(Format::Mcap)).collect();
    match found.is_empty() {
        false => Ok(found),
        true => {
            let folder = folder.display();
            let expected = format!(
                "a recording (.mcap) in the folder, as `hil run SCENE --out {folder} --record {folder}/run.mcap` writes it"
            );
            Err(FileError::whole(folder.to_string(), expected, "none"))
        }
    }
}

/// The recordings among what is to be served; none where that is a scene.
fn recordings(what: &[String]) -> Result<Vec<PathBuf>, Failure> {
    let (mut recordings, mut scenes) = (Vec::new(), 0);
    for name in what {
        let path = Path::new(name);
        if path.is_dir() {
            recordings.extend(in_folder(path)?);
            continue;
        }
        let named = path
            .extension()
            .is_some_and(|e| e.eq_ignore_ascii_case("mcap"));
        match format_of(path) {
            Some(Format::Mcap) => recordings.push(path.to_path_buf()),
            Some(Format::Toml) | None if !named => scenes += 1,
            Some(format) => {
                let expected = "a scene (TOML) or a recording of a run (.mcap)";
                return Err(FileError::whole(name, expected, format.noun()).into());
            }
            None => recordings.push(path.to_path_buf()),
        }
    }
    if recordings.len() > MOST {
        let expected = "one or two recordings (.mcap) to show beside each other";
        let found = format!("{} in the folder; name two of them", recordings.len());
        return Err(FileError::whole(what.join(", "), expected, found).into());
    }
    match what {
        [_, other] if scenes > 0 => {
            let expected = "one scene, or one or two recordings (.mcap) to show beside each other";
            Err(FileError::whole(other, expected, "a scene among two").into())
        }
        _ => Ok(recordings),
    }
}
