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
    /// A bus or device failed: exit 3.
    Device(String),
    /// The guard stopped the run: exit 4.
    Guard(String),
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
            Self::Input(_) => 2,
            Self::Device(_) | Self::Write { .. } => 3,
            Self::Guard(_) => 4,
        }
    }
}

impl fmt::Display for Failure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Check(message)
            | Self::Input(message)
            | Self::Device(message)
            | Self::Guard(message) => f.write_str(message),
            Self::Write { path, error } => write!(f, "{path}: cannot be written: {error}"),
        }
    }
}

impl std::error::Error for Failure {}

impl From<FileError> for Failure {
    fn from(error: FileError) -> Self {
        Self::Input(error.to_string())
    }
}
