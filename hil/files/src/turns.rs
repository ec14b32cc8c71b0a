//! Rows of several sensors that take turns: one of each makes a row of the skin.

use std::ops::Range;

use super::dialect::Row;
use super::number::Number;
use super::taken::Turns;

/// The sensors whose rows take turns, and what came of their rows.
#[derive(Debug)]
pub(super) struct Parts {
    turns: Turns,
    /// The sensor of the row that was looked at last.
    now: usize,
    /// Rows of other sensors.
    passed: usize,
    /// Rows that a later one of their sensor replaced before all had come.
    replaced: usize,
    /// `true` where the table ended before all sensors had come once more.
    pub(super) is_cut: bool,
}

/// The parts of a row of the skin.
pub(super) struct Frame<V> {
    parts: Vec<Option<Vec<V>>>,
}

impl Parts {
    pub(super) const fn new(turns: Turns) -> Self {
        Self {
            turns,
            now: 0,
            passed: 0,
            replaced: 0,
            is_cut: false,
        }
    }

    /// The columns of a row's sensor among those of all; none for a sensor that is not of this skin.
    pub(super) fn columns(&mut self, row: Row<'_>) -> Option<Range<usize>> {
        let id = row.get(self.turns.place);
        let mut begin = 0;
        for (number, (name, count)) in self.turns.sensors.iter().enumerate() {
            if name == id {
                self.now = number;
                return Some(begin..begin + count);
            }
            begin += count;
        }
        self.passed += 1;
        None
    }

    /// Words for what a table without a row of the skin lacks.
    pub(super) fn expected(&self) -> String {
        let names: Vec<&str> = self
            .turns
            .sensors
            .iter()
            .map(|(name, _)| name.as_str())
            .collect();
        format!(
            "a row of each sensor ({}) in column {}",
            names.join(", "),
            self.turns.place + 1
        )
    }

    pub(super) fn found(&self) -> String {
        format!("none of all, {} rows of others", self.passed)
    }

    /// Notes on the rows.
    pub(super) fn notes(&mut self) -> Vec<String> {
        let mut notes = Vec::new();
        if self.passed > 0 {
            notes.push(format!(
                "{} rows of other sensors were passed over",
                self.passed
            ));
        }
        if self.replaced > 0 {
            notes.push(format!(
                "{} rows were replaced by a later one of their sensor before all sensors had come",
                self.replaced
            ));
        }
        if self.is_cut {
            notes.push("the last rows are not of all sensors, and were left out".to_owned());
        }
        notes
    }
}

impl<V: Number> Frame<V> {
    /// An empty frame.
    pub(super) fn new(parts: Option<&Parts>) -> Self {
        let count = parts.map_or(0, |parts| parts.turns.sensors.len());
        Self {
            parts: (0..count).map(|_| None).collect(),
        }
    }

    /// Tells whether some sensors have come, and not all.
    pub(super) fn begun(&self) -> bool {
        self.parts.iter().any(Option::is_some)
    }

    /// Takes the values of the row that was looked at last; with the last sensor's they become those of all.
    pub(super) fn add(&mut self, parts: &mut Parts, values: &mut Vec<V>) -> bool {
        let slot = &mut self.parts[parts.now];
        parts.replaced += usize::from(slot.is_some());
        *slot = Some(std::mem::take(values));
        let is_whole = self.parts.iter().all(Option::is_some);
        if is_whole {
            values.extend(self.parts.iter_mut().filter_map(Option::take).flatten());
        }
        is_whole
    }
}
