//! Columns that are taken from a table, and what is said of those that cannot be.

use super::gain::Gain;

/// A column that is taken: where it stands, and what the header calls it; empty without a header.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Taken {
    pub(super) place: usize,
    pub(super) name: String,
    /// Makes counts of values in another unit.
    pub(super) gain: Option<Gain>,
    /// `true` where its counts fall when the layout's rise: its module is mounted the other way.
    pub(super) is_opposite: bool,
}

impl Taken {
    /// A column of counts.
    pub(super) const fn new(place: usize, name: String) -> Self {
        Self {
            place,
            name,
            gain: None,
            is_opposite: false,
        }
    }

    /// The column as errors name it.
    pub(super) fn key(&self) -> String {
        match self.name.as_str() {
            "" => format!("column {}", self.place + 1),
            name => format!("column {} ({name})", self.place + 1),
        }
    }
}

/// Columns that are taken, and what is to be said of the choice.
pub(super) type Chosen = (Vec<Taken>, Option<String>);

/// Key, expected and found.
pub(super) type Wrong = (Option<String>, String, String);

/// A field as messages show it.
pub(super) fn shown(field: &str) -> String {
    if field.is_empty() {
        return "nothing".into();
    }
    let text: String = field.chars().take(40).collect();
    format!("`{}`", text.escape_debug())
}

/// Columns that say when, not what.
pub(super) const TIMES: [&str; 3] = ["time_us", "timestamp", "time"];

/// The place of a column in a table without a heading, where it is called by its number, from 1.
pub(super) fn numbered(name: &str) -> Option<usize> {
    name.parse::<usize>().ok()?.checked_sub(1)
}

/// The sensors of rows that take turns.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Turns {
    /// The column that names the sensor of a row.
    pub(super) place: usize,
    /// The names, in the order of the modules, and how many columns each has.
    pub(super) sensors: Vec<(String, usize)>,
}
