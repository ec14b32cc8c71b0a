//! The one error of every file that a user hands in: its place, the expectation, and the finding there.

use std::{fmt, io};

use serde::Serialize;

/// A file that cannot be used, in words by which its author can mend it. Its display is
/// `file:line: key: expected ..., found ...`; a retry without an edit does not help.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, thiserror::Error)]
pub struct FileError {
    /// The file as the user named it; a built-in one under its place in `fixtures/`.
    #[serde(rename = "file")]
    pub path: String,
    /// The line, counted from one; none when the file as a whole is meant.
    pub line: Option<usize>,
    /// The key's full path (`touches[0].force_n.mean`) or the CSV column; none when no key is meant.
    pub key: Option<String>,
    /// Right text in its place.
    pub expected: String,
    /// Text that was there instead.
    pub found: String,
}

impl FileError {
    /// An error about a whole file.
    #[must_use]
    pub fn whole(
        path: impl Into<String>,
        expected: impl Into<String>,
        found: impl Into<String>,
    ) -> Self {
        Self {
            path: path.into(),
            line: None,
            key: None,
            expected: expected.into(),
            found: found.into(),
        }
    }
}

/// Words for the system's error on a file.
#[must_use]
pub fn said(error: &io::Error) -> String {
    match error.kind() {
        io::ErrorKind::NotFound => "no such file or folder".into(),
        _ => unnumbered(&error.to_string()),
    }
}

/// A text without the numbers that the system gives its errors, such as ` (os error 2)`: people read the words.
#[must_use]
pub fn unnumbered(text: &str) -> String {
    const MARK: &str = " (os error ";
    let mut parts = text.split(MARK);
    let mut plain = parts.next().unwrap_or_default().to_owned();
    for part in parts {
        let end = part.trim_start_matches(|c: char| c.is_ascii_digit() || c == '-');
        match end.strip_prefix(')') {
            Some(rest) => plain.push_str(rest),
            None => plain.extend([MARK, part]),
        }
    }
    plain
}

impl fmt::Display for FileError {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(out, "{}", self.path)?;
        if let Some(line) = self.line {
            write!(out, ":{line}")?;
        }
        if let Some(key) = &self.key {
            write!(out, ": {key}")?;
        }
        write!(out, ": expected {}, found {}", self.expected, self.found)
    }
}

#[cfg(test)]
#[path = "error_tests.rs"]
mod tests;
