//! Failures that end a command: a message and an exit status.

use std::io;
use std::path::Path;

use palpate_files::{FileError, unnumbered};
use palpate_records::damage::Damage;

/// Failures of a command; the kinds are the exit statuses of the command line. The words have no number of the system's
/// errors, whatever they quote.
#[derive(Debug, thiserror::Error)]
pub enum Failure {
    /// A check failed: exit 1. Empty where the command has said everything already.
    #[error("{}", unnumbered(.0))]
    Check(String),
    /// Usage or bad input: exit 2.
    #[error("{}", unnumbered(.0))]
    Input(String),
    /// A file that cannot be used, with its place in it: exit 2.
    #[error(transparent)]
    File(#[from] FileError),
    /// A bus or device failed: exit 3.
    #[error("{}", unnumbered(.0))]
    Device(String),
    /// The guard stopped the run: exit 4.
    #[error("{}", unnumbered(.0))]
    Guard(String),
    /// A signal came before the output was whole: exit 130.
    #[error("{}", unnumbered(.0))]
    Stopped(String),
    /// An output could not be written: exit 3.
    #[error("{path}: cannot be written: {}", unwritten(error))]
    Write {
        /// The file or stream.
        path: String,
        /// Error of the system.
        #[source]
        error: io::Error,
    },
}

impl Failure {
    /// Makes a system's error on a file or stream the failure to write it.
    pub fn written(path: impl AsRef<Path>) -> impl FnOnce(io::Error) -> Self {
        move |error| Self::Write {
            path: path.as_ref().display().to_string(),
            error,
        }
    }

    /// The exit status.
    pub const fn status(&self) -> u8 {
        match self {
            Self::Check(_) => 1,
            Self::Input(_) | Self::File(_) => 2,
            Self::Device(_) | Self::Write { .. } => 3,
            Self::Guard(_) => 4,
            Self::Stopped(_) => 130,
        }
    }

    /// The file that cannot be used or written, as its user named it; none where no file is to blame.
    pub fn file(&self) -> Option<&str> {
        match self {
            Self::File(error) => Some(&error.path),
            Self::Write { path, .. } => Some(path),
            _ => None,
        }
    }

    /// The line of [`Self::file`] that is wrong, counted from one.
    pub fn line(&self) -> Option<usize> {
        match self {
            Self::File(error) => error.line,
            _ => None,
        }
    }

    /// The key or column of [`Self::file`] that is wrong, in full.
    pub fn key(&self) -> Option<&str> {
        match self {
            Self::File(error) => error.key.as_deref(),
            _ => None,
        }
    }
}

/// Words for an output that could not be written.
fn unwritten(error: &io::Error) -> String {
    match error.kind() {
        io::ErrorKind::NotFound => "its folder is not there".into(),
        _ => unnumbered(&error.to_string()),
    }
}

/// Error of a file of ours, under the name that its user gave, with this damage in it.
pub fn damaged(path: impl Into<String>, damage: Damage) -> FileError {
    FileError {
        line: Some(damage.line),
        ..FileError::whole(path, damage.expected, damage.found)
    }
}
