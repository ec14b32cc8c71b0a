//! Damage of a text that Palpate wrote, with its line.

/// The first line that has no place in a golden, a schedule file or a table of contacts.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("line {line}: expected {expected}, found {found}")]
pub struct Damage {
    /// Line, counted from one.
    pub line: usize,
    /// Content that should be there.
    pub expected: String,
    /// Content that is there.
    pub found: String,
}

impl Damage {
    /// Damage of line number `line`, which reads `found` in place of `expected`.
    pub(crate) fn of_line(line: usize, expected: &str, found: &str) -> Self {
        Self {
            line,
            expected: expected.to_owned(),
            found: shown(found),
        }
    }
}

/// A damaged line as a message shows it.
fn shown(text: &str) -> String {
    if text.is_empty() {
        return "an empty line".to_owned();
    }
    let cut: String = text.chars().take(60).collect();
    let dots = if cut.len() < text.len() { ".." } else { "" };
    format!("`{}{dots}`", cut.trim_end().escape_default())
}
