//! What can go wrong here, said with the file it went wrong in.

use std::path::Path;

/// The message is the error.
#[derive(Debug, thiserror::Error)]
pub enum Failure {
    #[error("{path}: {what}")]
    File { path: String, what: String },
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
