//! The program as a user meets it: arguments in; streams, files and an exit status out.

// A failed expectation in a test is its message.
#![allow(clippy::unwrap_used, clippy::panic, clippy::float_cmp)]

#[path = "cli/calibrate.rs"]
mod calibrate;
#[path = "cli/compare.rs"]
mod compare;
#[path = "cli/contacts.rs"]
mod contacts;
#[path = "cli/contacts_along.rs"]
mod contacts_along;
#[path = "cli/diff.rs"]
mod diff;
#[path = "cli/docs.rs"]
mod docs;
#[path = "cli/figures.rs"]
mod figures;
#[path = "cli/files.rs"]
mod files;
#[path = "cli/fingers.rs"]
mod fingers;
#[path = "cli/foxglove.rs"]
mod foxglove;
#[path = "cli/hardware.rs"]
mod hardware;
#[path = "cli/identify.rs"]
mod identify;
#[path = "cli/import.rs"]
mod import;
#[path = "cli/input.rs"]
mod input;
#[path = "cli/interrupt.rs"]
mod interrupt;
#[path = "cli/level.rs"]
mod level;
#[path = "cli/mistakes.rs"]
mod mistakes;
#[path = "cli/motors.rs"]
mod motors;
#[path = "cli/outputs.rs"]
mod outputs;
#[path = "cli/project.rs"]
mod project;
#[path = "cli/pulse.rs"]
mod pulse;
#[path = "cli/readers.rs"]
mod readers;
#[path = "cli/recipes.rs"]
mod recipes;
#[path = "cli/recordings.rs"]
mod recordings;
#[path = "cli/records.rs"]
mod records;
#[path = "cli/reproduce.rs"]
mod reproduce;
#[path = "cli/review.rs"]
mod review;
#[path = "cli/run.rs"]
mod run;
#[path = "cli/serve.rs"]
mod serve;
#[path = "cli/serve_crowd.rs"]
mod serve_crowd;
#[path = "cli/serve_packed.rs"]
mod serve_packed;
#[path = "cli/serve_waits.rs"]
mod serve_waits;
#[path = "cli/shell.rs"]
mod shell;
#[path = "cli/skins.rs"]
mod skins;
#[path = "cli/study.rs"]
mod study;
#[path = "cli/study_page.rs"]
mod study_page;
#[path = "cli/study_session.rs"]
mod study_session;
#[path = "cli/sweep.rs"]
mod sweep;
#[path = "cli/test.rs"]
mod test;
#[path = "cli/texture.rs"]
mod texture;
#[path = "cli/texture_rate.rs"]
mod texture_rate;

use std::ffi::OsStr;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};
use std::sync::atomic::{AtomicU32, Ordering};

/// A folder of one test's own, gone when the test is over.
struct Folder(PathBuf);

impl Folder {
    fn new(name: &str) -> Self {
        // Tests run side by side, and two may choose one name.
        static COUNT: AtomicU32 = AtomicU32::new(0);
        let (process, count) = (std::process::id(), COUNT.fetch_add(1, Ordering::Relaxed));
        let path = std::env::temp_dir().join(format!("hil-cli-{name}-{process}-{count}"));
        fs::create_dir_all(&path).unwrap();
        Self(path)
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.join(name)
    }

    fn text(&self, name: &str) -> String {
        fs::read_to_string(self.path(name)).unwrap()
    }

    fn write(&self, name: &str, text: &str) -> PathBuf {
        let path = self.path(name);
        fs::write(&path, text).unwrap();
        path
    }

    /// Everything in it, by name.
    fn names(&self) -> Vec<String> {
        let entries = fs::read_dir(&self.0).unwrap();
        let name = |e: std::io::Result<fs::DirEntry>| e.unwrap().file_name().into_string().unwrap();
        let mut names: Vec<_> = entries.map(name).collect();
        names.sort();
        names
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        let _ = fs::remove_dir_all(&self.0);
    }
}

fn command<S: AsRef<OsStr>>(args: &[S], folder: &Path) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_hil"));
    command.args(args).current_dir(folder).stdin(Stdio::null());
    command
}

/// What a run of the program came to.
struct Said {
    status: Option<i32>,
    out: String,
    err: String,
}

impl From<Output> for Said {
    fn from(output: Output) -> Self {
        let said = Self {
            status: output.status.code(),
            out: String::from_utf8(output.stdout).unwrap(),
            err: String::from_utf8(output.stderr).unwrap(),
        };
        assert!(!said.err.contains("panicked"), "{}", said.err);
        said
    }
}

/// Runs the program in `folder`.
fn hil_in<S: AsRef<OsStr>>(folder: &Path, args: &[S]) -> Said {
    command(args, folder).output().unwrap().into()
}

/// Runs the program where nothing of the project lies around.
fn hil<S: AsRef<OsStr>>(args: &[S]) -> Said {
    hil_in(&std::env::temp_dir(), args)
}

/// Its standard output; it must succeed and have nothing to remark.
fn good<S: AsRef<OsStr>>(args: &[S]) -> String {
    let said = hil(args);
    assert_eq!((said.status, said.err.as_str()), (Some(0), ""));
    said.out
}

/// Its message; it must refuse with exit 2 and print nothing else.
fn refused<S: AsRef<OsStr>>(args: &[S]) -> String {
    let said = hil(args);
    assert_eq!(
        (said.status, said.out.as_str()),
        (Some(2), ""),
        "{}",
        said.err
    );
    assert!(said.err.starts_with("error: "), "{}", said.err);
    said.err
}

/// `refused`, and every one of `words` must stand in the message.
fn refused_with<S: AsRef<OsStr>>(args: &[S], words: &[&str]) {
    let message = refused(args);
    for word in words {
        assert!(message.contains(word), "no `{word}` in: {message}");
    }
}

/// A bench of hardware that is not there.
fn real_bench(folder: &Folder) -> String {
    let file = folder.path("real.toml").display().to_string();
    good(&[
        "new",
        "bench",
        "real",
        "--can",
        "nope0",
        "--i2c",
        "/dev/i2c-250",
        "--out",
        &file,
    ]);
    file
}
