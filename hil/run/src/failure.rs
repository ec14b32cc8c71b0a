//! How a command ends when it does not succeed: a message and an exit status.

use std::fmt;

use palpate_files::FileError;

/// Why a command failed; the kinds are the exit statuses of the command line.
#[derive(Debug)]
pub enum Failure {
    /// A check failed: exit 1. Empty where the command has said everything already.
    Check(String),
    /// Usage or bad input: exit 2.
    Input(String),
    /// A file that cannot be used, with its place in it: exit 2.
    File(FileError),
    /// A bus or device failed: exit 3.
    Device(String),
    /// The guard stopped the run: exit 4.
    Guard(String),
    /// A signal came before the output was whole: exit 130.
    Stopped(String),
    /// An output could not be written: exit 3.
    Write {
        /// The file or stream.
        path: String,
        /// What the system said.
        error: std::io::Error,
    },
}

impl Failure {
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

impl fmt::Display for Failure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Check(message)
            | Self::Input(message)
            | Self::Device(message)
            | Self::Guard(message)
            | Self::Stopped(message) => f.write_str(message),
            Self::File(error) => error.fmt(f),
            Self::Write { path, error } => write!(f, "{path}: cannot be written: {error}"),
        }
    }
}

impl std::error::Error for Failure {
    fn source(&self) -> Option<&(dyn std::error::Error + 'static)> {
        match self {
            Self::Write { error, .. } => Some(error),
            _ => None, // a file's error is the message itself
        }
    }
}

impl From<FileError> for Failure {
    fn from(error: FileError) -> Self {
        Self::File(error)
    }
}
