//! One program a bus: an advisory lock on a file beside the system's other locks, which ends with its holder.
//!
//! Not on the device node: the kernel keeps an adapter that was unplugged for as long as anybody has its node
//! open, and a lock is held for a whole run.

use std::fs::{self, File, OpenOptions};
use std::os::unix::fs::{MetadataExt, PermissionsExt};
use std::path::{Path, PathBuf};
use std::time::Duration;

use nix::errno::Errno;
use nix::fcntl::{Flock, FlockArg};
use nix::sys::signal::{Signal, kill};
use nix::unistd::Pid;
use palpate_core::units::Duration as Span;

use crate::pacer::RunClock;

/// The lock, for as long as it lives.
#[derive(Debug)]
pub struct BusLock {
    _held: Flock<File>,
}

/// Why there is none.
#[derive(Debug, thiserror::Error)]
pub enum LockError {
    /// Another program has it: its process number, where the system tells.
    #[error("{path}: in use by {}; two programs on one bus would undo each other's work", who(*.pid))]
    Held {
        /// The device node.
        path: String,
        /// The holder.
        pid: Option<u32>,
    },
    /// The lock's file cannot be opened.
    #[error("{path}: {error}; it says which program has a bus")]
    Open {
        /// The file.
        path: String,
        /// What the system said.
        error: std::io::Error,
    },
}

fn who(pid: Option<u32>) -> String {
    let Some(pid) = pid else {
        return "another program".into();
    };
    let name = fs::read_to_string(format!("/proc/{pid}/comm")).unwrap_or_default();
    format!("process {pid} ({})", name.trim())
}

/// The file that stands for a bus, whatever name it goes by.
fn file_of(folder: &Path, bus: &Path) -> PathBuf {
    let bus = fs::canonicalize(bus).unwrap_or_else(|_| bus.to_owned());
    let name = bus.display().to_string().replace('/', "-");
    folder.join(format!("palpate{name}.lock"))
}

/// Opens the file, which may be another user's, or makes it, for all users.
fn open(path: &Path) -> std::io::Result<File> {
    if let Ok(there) = File::open(path) {
        return Ok(there);
    }
    let mut options = OpenOptions::new();
    let file = options.read(true).append(true).create(true).open(path)?;
    // Permissions of another user's file are its owner's to set.
    let _ = file.set_permissions(fs::Permissions::from_mode(0o666));
    Ok(file)
}

impl BusLock {
    /// Locks a bus.
    ///
    /// # Errors
    /// [`LockError`]; a held lock names its holder.
    pub fn take(path: &Path) -> Result<Self, LockError> {
        let system = Path::new("/run/lock");
        if system.is_dir() {
            Self::within(system, path)
        } else {
            Self::within(&std::env::temp_dir(), path)
        }
    }

    fn within(folder: &Path, path: &Path) -> Result<Self, LockError> {
        let name = || path.display().to_string();
        let lock = file_of(folder, path);
        let file = open(&lock).map_err(|error| LockError::Open {
            path: lock.display().to_string(),
            error,
        })?;
        match Flock::lock(file, FlockArg::LockExclusiveNonblock) {
            Ok(held) => Ok(Self { _held: held }),
            Err((file, Errno::EWOULDBLOCK)) => Err(LockError::Held {
                path: name(),
                pid: holder(&file),
            }),
            Err((_, errno)) => Err(LockError::Open {
                path: name(),
                error: errno.into(),
            }),
        }
    }

    /// Locks a bus, and ends the guardian that has it. Returns who that was.
    ///
    /// # Errors
    /// [`LockError`] when another program has it, or the guardian does not end within `patience`.
    pub fn take_over(path: &Path, patience: Duration) -> Result<(Self, Option<String>), LockError> {
        let clock = RunClock::start();
        let mut ended = None;
        loop {
            let error = match Self::take(path) {
                Ok(lock) => return Ok((lock, ended)),
                Err(error) => error,
            };
            let LockError::Held { pid: Some(pid), .. } = &error else {
                return Err(error);
            };
            let late = u128::from(clock.now().as_micros()) > patience.as_micros();
            // Only what locks as we do is ended: the guardian runs the same program as we.
            if late || !is_same_program(*pid) {
                return Err(error);
            }
            if ended.is_none() {
                ended = Some(who(Some(*pid)));
                let _ = kill(Pid::from_raw(*pid as i32), Signal::SIGTERM);
            }
            clock.sleep_until(clock.now() + Span::from_millis(2));
        }
    }
}

fn is_same_program(pid: u32) -> bool {
    let name = |pid: &str| fs::read_to_string(format!("/proc/{pid}/comm")).ok();
    name("self").is_some_and(|ours| name(&pid.to_string()) == Some(ours))
}

/// Who holds a lock on this file, by `/proc/locks`: `1: FLOCK ADVISORY WRITE 4711 00:05:123 0 EOF`.
fn holder(file: &File) -> Option<u32> {
    let inode = file.metadata().ok()?.ino().to_string();
    let locks = fs::read_to_string("/proc/locks").ok()?;
    locks.lines().find_map(|line| {
        let mut words = line.split_whitespace().filter(|w| *w != "->");
        let kind = words.nth(1)?;
        let pid = words.nth(2)?;
        let place = words.next()?;
        let ours = kind == "FLOCK" && place.rsplit(':').next() == Some(&inode);
        ours.then(|| pid.parse().ok())?
    })
}

#[cfg(test)]
#[path = "lock_tests.rs"]
mod tests;
