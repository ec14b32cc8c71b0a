//! A row of the thesis: its statement, its computation, its answer and its mark.

use palpate_run::Failure;
use serde_json::{Map, Value};

/// Comparison of a row with the thesis.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Mark {
    /// The program gives what the thesis says.
    Agrees,
    /// The program gives something else, and a sweep shows the cause.
    Differs(String),
    /// The program gives something else, and nothing here shows why.
    Unexplained,
    /// Nobody can say: the thesis has people, hardware or data that are not here.
    Unknown(String),
}

impl Mark {
    /// Every word of a mark, in the order in which rows are counted.
    pub const WORDS: [&'static str; 3] = ["agrees", "differs", "cannot be known"];

    /// The mark in words.
    pub const fn word(&self) -> &'static str {
        match self {
            Self::Agrees => Self::WORDS[0],
            Self::Differs(_) | Self::Unexplained => Self::WORDS[1],
            Self::Unknown(_) => Self::WORDS[2],
        }
    }

    /// The reason of a mark, where it has one.
    pub fn cause(&self) -> Option<&str> {
        match self {
            Self::Agrees => None,
            Self::Differs(cause) | Self::Unknown(cause) => Some(cause),
            Self::Unexplained => Some("unexplained"),
        }
    }

    /// Agreement where `same` holds, else a difference with this cause.
    pub(super) fn new(same: bool, cause: impl FnOnce() -> String) -> Self {
        match same {
            true => Self::Agrees,
            false => Self::Differs(cause()),
        }
    }
}

/// Result of a row.
#[derive(Clone, Debug, PartialEq)]
pub struct Answer {
    /// Comparison with the thesis.
    pub mark: Mark,
    /// Result in words.
    pub found: String,
    /// Numbers that went in and came out, by name.
    pub values: Map<String, Value>,
    /// Panels of the figure, SVG for a page with the style sheet of reports.
    pub panels: Vec<String>,
}

impl Answer {
    /// An answer with the numbers of a JSON object.
    pub(super) fn new(mark: Mark, found: impl Into<String>, values: Value) -> Self {
        let values = match values {
            Value::Object(values) => values,
            _ => Map::new(),
        };
        Self {
            mark,
            found: found.into(),
            values,
            panels: Vec::new(),
        }
    }

    /// The answer with panels of the figure.
    pub(super) fn drawn(self, panels: impl IntoIterator<Item = String>) -> Self {
        Self {
            panels: panels.into_iter().collect(),
            ..self
        }
    }
}

/// One figure, table, equation or claim of the thesis.
#[derive(Clone, Copy, Debug)]
pub struct Row {
    /// Name of the row: kind, number and a word, such as `claim-5.4-power`.
    pub id: &'static str,
    /// Statement of the thesis.
    pub says: &'static str,
    /// Values and rules that the thesis does not print.
    pub assumed: &'static str,
    /// Computation of the answer.
    pub compute: fn() -> Result<Answer, Failure>,
}

impl Row {
    /// The command that makes this row alone.
    pub fn command(&self) -> String {
        format!("hil reproduce {}", self.id)
    }
}

/// A failure from an error that only wrong constants of this module can cause.
pub(super) fn broken(error: impl std::fmt::Display) -> Failure {
    Failure::Input(format!("hil reproduce: {error}"))
}
