//! One program a bus: an advisory lock on a file beside the system's other locks, which ends with its holder.
//!
//! Not on the device node: the kernel keeps an adapter that was unplugged for as long as anybody has its node
//! open, and a lock is held for a whole run.
//!
//! The file is also the way to its holder. Another program that wants everything off writes a word into it, and the
//! guardian that holds it looks there. So it is found whatever its program is called and whichever processes can be seen.

use std::fs::{self, File, OpenOptions};
use std::io::{self, Write};
use std::os::unix::fs::{MetadataExt, OpenOptionsExt, PermissionsExt};
use std::path::{Path, PathBuf};

use nix::errno::Errno;
use nix::fcntl::{Flock, FlockArg};
use nix::libc;

/// The lock, for as long as it lives.
#[derive(Debug)]
pub struct BusLock {
    held: Flock<File>,
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
        error: io::Error,
    },
}

impl LockError {
    /// Who holds the lock, in words.
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

/// The file that stands for a bus, whatever name it goes by.
fn file_of(folder: &Path, bus: &Path) -> PathBuf {
    let bus = fs::canonicalize(bus).unwrap_or_else(|_| bus.to_owned());
    let name = bus.display().to_string().replace('/', "-");
    folder.join(format!("palpate{name}.lock"))
}

/// Opens the file, which may be another user's, or makes it, for all users. Neither a link is followed nor a pipe waited for:
/// anybody may write to that folder.
fn open(path: &Path) -> io::Result<File> {
    let mut options = OpenOptions::new();
    options.custom_flags(libc::O_NOFOLLOW | libc::O_NONBLOCK);
    let file = options.read(true).append(true).open(path);
    let file = match file {
        // A lock needs no right to write, a word to its holder does.
        Err(error) if error.kind() == io::ErrorKind::PermissionDenied => {
            options.append(false).open(path)?
        }
        Err(error) if error.kind() == io::ErrorKind::NotFound => {
            match options.create_new(true).open(path) {
                Ok(file) => {
                    // Permissions of another user's file are its owner's to set.
                    let _ = file.set_permissions(fs::Permissions::from_mode(0o666));
                    file
                }
                // Another program was faster.
                Err(error) if error.kind() == io::ErrorKind::AlreadyExists => {
                    options.create_new(false).open(path)?
                }
                Err(error) => return Err(error),
            }
        }
        other => other?,
    };
    if !file.metadata()?.is_file() {
        return Err(io::Error::other("expected an ordinary file"));
    }
    Ok(file)
}

/// The folder of locks.
fn folder() -> PathBuf {
    let system = Path::new("/run/lock");
    match system.is_dir() {
        true => system.to_owned(),
        false => std::env::temp_dir(),
    }
}

/// Writes into a bus's lock that its holder is to switch everything off and end.
///
/// # Errors
/// [`LockError::Open`].
pub fn ask_off(bus: &Path) -> Result<(), LockError> {
    let lock = file_of(&folder(), bus);
    let asked = open(&lock).and_then(|mut file| file.write_all(b"off\n"));
    asked.map_err(|error| LockError::Open {
        path: lock.display().to_string(),
        error,
    })
}

impl BusLock {
    /// Locks a bus.
    ///
    /// # Errors
    /// [`LockError`]; a held lock names its holder.
    pub fn take(path: &Path) -> Result<Self, LockError> {
        Self::within(&folder(), path)
    }

    fn within(folder: &Path, path: &Path) -> Result<Self, LockError> {
        let lock = file_of(folder, path);
        let fail = |error: io::Error| LockError::Open {
            path: lock.display().to_string(),
            error,
        };
        loop {
            let file = open(&lock).map_err(fail)?;
            let held = match Flock::lock(file, FlockArg::LockExclusiveNonblock) {
                Ok(held) => held,
                Err((file, Errno::EWOULDBLOCK)) => {
                    return Err(LockError::Held {
                        path: path.display().to_string(),
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
                // What was asked of an earlier holder is done.
                let _ = held.set_len(0);
                return Ok(Self { held });
            }
        }
    }

    /// Whether another program has asked for everything off since the lock was taken.
    pub fn is_asked_off(&self) -> bool {
        self.held.metadata().is_ok_and(|file| file.len() > 0)
    }
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
