//! One program a bus: an advisory lock on a file beside the system's other locks, which ends with its holder.
//!
//! The lock is not on the device node: the kernel keeps an adapter that was unplugged for as long as anybody has its
//! node open, and a lock is held for a whole run.
//!
//! The file is also the way to its holder. Another program that wants everything off writes a word into it, and the
//! guardian that holds it looks there. So it is found whatever its program is called and whichever processes can be
//! seen. Nothing takes the file away: everybody who opens it finds the file that others have locked.

use std::fs::{self, File};
use std::io;
use std::os::unix::fs::{FileExt, MetadataExt};
use std::path::{Path, PathBuf};

use nix::errno::Errno;
use nix::fcntl::{Flock, FlockArg};

use crate::hardware::Hardware;
use crate::shared_file::{open, open_or_create, refuse_newer};

/// The version of a lock's file that this code writes.
const VERSION: u32 = 1;
/// Kind of file, at the beginning of a lock file's first line.
const KIND: &str = "palpate-lock";
/// Bytes that no first line exceeds.
const FIRST: usize = 64;
/// The bit of a folder's mode by which everybody may write there.
const OTHERS: u32 = 0o002;

/// The lock, for as long as it lives.
#[derive(Debug)]
pub struct BusLock {
    held: Flock<File>,
    hardware: Hardware,
    /// Bytes of the file while nobody asks for everything off.
    length: u64,
}

/// Errors of a lock that is not to be had.
#[derive(Debug, thiserror::Error)]
pub enum LockError {
    /// Another program has it: its process number, where the system tells.
    #[error("{path}: in use by {}; two programs on one bus would undo each other's work", who(*.pid))]
    Held {
        /// The hardware, as its user named it.
        path: String,
        /// Process number of the holder, where the system tells it.
        pid: Option<u32>,
    },
    /// The lock's file cannot be used.
    #[error("{path}: {error}; it says which program has a bus")]
    Open {
        /// The file.
        path: String,
        /// Error of the system.
        error: io::Error,
    },
}

impl LockError {
    /// Words for the process that holds the lock.
    pub fn holder(&self) -> String {
        match self {
            Self::Held { pid, .. } => who(*pid),
            Self::Open { .. } => "nobody".into(),
        }
    }
}

fn who(pid: Option<u32>) -> String {
    let Some(pid) = pid else {
        return "another program".into();
    };
    let name = fs::read_to_string(format!("/proc/{pid}/comm")).unwrap_or_default();
    format!("process {pid} ({})", name.trim())
}

/// File of the lock of hardware.
fn file_of(folder: &Path, hardware: &Hardware) -> PathBuf {
    folder.join(format!("palpate-{}.lock", hardware.file()))
}

/// Content of the file while nobody asks for everything off.
fn content(hardware: &Hardware) -> String {
    format!("{KIND} {VERSION}\n{}\n", hardware.place())
}

/// Refuses a file that a newer version has left: its further locks are not known here.
fn known(file: &File) -> io::Result<()> {
    let mut first = [0; FIRST];
    let length = file.read_at(&mut first, 0)?;
    refuse_newer(&first[..length], KIND, VERSION)
}

/// The folder of locks.
fn folder() -> &'static Path {
    for_all(Path::new("/run/lock"))
}

/// A folder for all users: some systems let root alone write to the system's.
fn for_all(system: &Path) -> &Path {
    let is_open = |about: fs::Metadata| about.is_dir() && about.mode() & OTHERS != 0;
    match fs::metadata(system).is_ok_and(is_open) {
        true => system,
        false => Path::new("/tmp"),
    }
}

/// Writes into a lock that its holder is to switch everything off and end.
///
/// # Errors
/// [`LockError::Open`].
pub fn ask_off(hardware: &Hardware) -> Result<(), LockError> {
    ask_off_within(folder(), hardware)
}

fn ask_off_within(folder: &Path, hardware: &Hardware) -> Result<(), LockError> {
    let lock = file_of(folder, hardware);
    let asked = open(&lock, true).and_then(|file| {
        known(&file)?;
        // There is room for the word: the file has its block.
        file.write_all_at(b"off\n", content(hardware).len() as u64)
    });
    asked.map_err(|error| LockError::Open {
        path: lock.display().to_string(),
        error,
    })
}

impl BusLock {
    /// Locks hardware.
    ///
    /// # Errors
    /// [`LockError`]; a held lock names its holder.
    pub fn take(hardware: &Hardware) -> Result<Self, LockError> {
        Self::within(folder(), hardware)
    }

    pub(crate) fn within(folder: &Path, hardware: &Hardware) -> Result<Self, LockError> {
        let lock = file_of(folder, hardware);
        let fail = |error: io::Error| LockError::Open {
            path: lock.display().to_string(),
            error,
        };
        let content = content(hardware);
        let length = content.len() as u64;
        loop {
            let file = open_or_create(&lock).map_err(fail)?;
            let held = match Flock::lock(file, FlockArg::LockExclusiveNonblock) {
                Ok(held) => held,
                Err((file, Errno::EWOULDBLOCK)) => {
                    return Err(LockError::Held {
                        path: hardware.to_string(),
                        pid: holder(&file),
                    });
                }
                Err((_, errno)) => return Err(fail(errno.into())),
            };
            // A file that was taken away before it was locked is no other program's lock.
            let is_there = fs::symlink_metadata(&lock).is_ok_and(|there| {
                held.metadata()
                    .is_ok_and(|own| (own.dev(), own.ino()) == (there.dev(), there.ino()))
            });
            if is_there {
                // A wish to an earlier holder is done.
                known(&held)
                    .and_then(|()| held.write_all_at(content.as_bytes(), 0))
                    .and_then(|()| held.set_len(length))
                    .map_err(fail)?;
                return Ok(Self {
                    held,
                    hardware: hardware.clone(),
                    length,
                });
            }
        }
    }

    /// Hardware that is locked.
    pub const fn hardware(&self) -> &Hardware {
        &self.hardware
    }

    /// Tells whether another program has asked for everything off since the lock was taken.
    pub fn is_asked_off(&self) -> bool {
        self.held
            .metadata()
            .is_ok_and(|file| file.len() > self.length)
    }
}

/// The process that holds a lock on this file, if the system tells.
fn holder(file: &File) -> Option<u32> {
    let inode = file.metadata().ok()?.ino().to_string();
    holder_in(&fs::read_to_string("/proc/locks").ok()?, &inode)
}

/// The process that holds a lock on a file, by lines of `/proc/locks`: `1: FLOCK ADVISORY WRITE 4711 00:05:123 0 EOF`.
fn holder_in(locks: &str, inode: &str) -> Option<u32> {
    locks.lines().find_map(|line| {
        let mut words = line.split_whitespace().filter(|w| *w != "->");
        let kind = words.nth(1)?;
        let pid = words.nth(2)?;
        let place = words.next()?;
        let ours = kind == "FLOCK" && place.rsplit(':').next() == Some(inode);
        ours.then(|| pid.parse().ok())?
    })
}

#[cfg(test)]
#[path = "lock_tests.rs"]
mod tests;
