//! Failures of a training, each with the file it went wrong in, and files that are whole or absent.

use std::path::Path;

/// The message is the error.
#[derive(Debug, thiserror::Error)]
pub enum Failure {
    #[error("{path}: {what}")]
    File { path: String, what: String },
    #[error(transparent)]
    Rows(#[from] palpate_files::FileError),
    #[error("{0}")]
    Usage(String),
}

impl Failure {
    pub fn file(path: &Path, what: impl ToString) -> Self {
        Self::File {
            path: path.display().to_string(),
            what: what.to_string(),
        }
    }
}

/// Writes a file, whole or not at all.
pub fn write(path: &Path, bytes: &[u8]) -> Result<(), Failure> {
    let partial = path.with_extension("partial");
    std::fs::write(&partial, bytes)
        .and_then(|()| std::fs::rename(&partial, path))
        .map_err(|e| Failure::file(path, e))
}
