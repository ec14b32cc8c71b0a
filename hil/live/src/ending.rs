//! A signal while files are written: half-written files go, then the program.
//!
//! Before the first such file a signal ends the program as the system does. Commands that end in order when a signal
//! comes (`palpate_buses::signals`) are left to themselves.

use std::collections::BTreeSet;
use std::fs;
use std::io::{self, Read};
use std::os::unix::net::UnixStream;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, Once};

use palpate_buses::signals::Signals;
use signal_hook::consts::{SIGHUP, SIGINT, SIGTERM};
use signal_hook::low_level::pipe;

use crate::lock::held;

/// The files that are half-written.
static HALF: Mutex<BTreeSet<PathBuf>> = Mutex::new(BTreeSet::new());

/// A file that is being written under a name of its own until it is whole.
#[derive(Debug)]
pub struct Partial {
    path: PathBuf,
}

impl Partial {
    /// Makes the file; a signal from now on takes it along.
    ///
    /// # Errors
    /// Error of the system.
    pub fn create(path: &Path) -> io::Result<(Self, fs::File)> {
        static WATCHED: Once = Once::new();
        // Without a watch a signal leaves the file, and the next run of the command does not mind.
        WATCHED.call_once(|| drop(watch()));
        let mut half = held(&HALF);
        let file = fs::File::create(path)?;
        half.insert(path.to_path_buf());
        Ok((
            Self {
                path: path.to_path_buf(),
            },
            file,
        ))
    }

    /// Gives the file the name of the whole one.
    ///
    /// # Errors
    /// Error of the system; the file is gone then.
    pub fn finish(self, whole: &Path) -> io::Result<()> {
        fs::rename(&self.path, whole)
    }
}

impl Drop for Partial {
    fn drop(&mut self) {
        let mut half = held(&HALF);
        // Best effort: one that was renamed is not there.
        let _ = fs::remove_file(&self.path);
        half.remove(&self.path);
    }
}

/// Waits for signals on a thread.
fn watch() -> io::Result<()> {
    let (mut told, tells) = UnixStream::pair()?;
    for signal in [SIGINT, SIGTERM, SIGHUP] {
        let tells = tells.try_clone()?;
        pipe::register(signal, tells)?;
    }
    let wait = move || {
        let mut byte = [0];
        while told.read_exact(&mut byte).is_ok() {
            if Signals::are_caught() {
                continue;
            }
            // Held to the end: nothing is begun or renamed any more.
            let half = held(&HALF);
            for path in half.iter() {
                let _ = fs::remove_file(path);
            }
            std::process::exit(130);
        }
    };
    std::thread::Builder::new()
        .name("signals".into())
        .spawn(wait)
        .map(drop)
}
