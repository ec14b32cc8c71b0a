//! Lines before the rows of a table that no mark tells from them: words of the program that wrote it, the heading, and units.

use std::cmp::Reverse;

use super::dialect::{Dialect, Fields, SEPARATORS, Writing, is_remark, is_value};

/// Lines of a table's beginning that are looked at.
const LOOKED_AT: usize = 256;
/// Rows behind each other that show where a table begins.
const TELLING: usize = 3;

/// The beginning of a table behind other lines.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Preface {
    /// Lines before the heading, or before the first row where there is none.
    pub(super) lines: usize,
    /// `true` where the line below the heading has units.
    pub(super) has_units: bool,
    /// The separator, if the first line states it for a spreadsheet (`sep=;`).
    pub(super) separator: Option<u8>,
}

impl Preface {
    /// The preface of a text with this beginning; `None` for one that begins with its heading or first row.
    pub(super) fn find(start: &str, known: Writing) -> Option<Self> {
        let whole = start.rfind('\n').and_then(|end| start.get(..end))?;
        let mut separator = None;
        if let Some(stated) = whole.lines().next().and_then(|l| l.strip_prefix("sep=")) {
            separator = stated.trim_end().bytes().next();
        }
        let stated = separator.map(Some).or(known.separator);
        let stated = stated.as_ref().map(std::slice::from_ref);
        let candidates = stated.unwrap_or(&SEPARATORS).iter();
        let found = candidates.filter_map(|separator| Table::find(whole, *separator));
        // Between other separators than its own, a table begins later: words of a heading are fields there.
        let before = |table: &Table| table.begin + usize::from(table.has_units);
        let table = found.min_by_key(|table| (before(table), Reverse(table.width)))?;
        let preface = Self {
            lines: table.begin,
            has_units: table.has_units,
            separator,
        };
        (preface.lines > 0 || preface.has_units).then_some(preface)
    }

    /// The text behind the preface, without the line of units.
    pub(super) fn rest(self, start: &str) -> String {
        let mut lines = start.split_inclusive('\n').skip(self.lines);
        let mut rest: String = match self.has_units {
            true => {
                let names = lines.find(|line| !is_remark(line));
                let units = lines.find(|line| !is_remark(line));
                names.filter(|_| units.is_some()).unwrap_or_default().into()
            }
            false => String::new(),
        };
        rest.extend(lines);
        rest
    }

    /// Remark on the lines that were passed over.
    pub(super) fn note(self, start: &str) -> Option<String> {
        let first = start.lines().find(|line| !is_remark(line))?;
        let first: String = first.chars().take(40).collect();
        match (self.lines, self.has_units) {
            (0, false) => None,
            (0, true) => Some("the line below the heading has units".to_owned()),
            (lines, _) => Some(format!(
                "the table begins behind {lines} lines, from `{first}` on"
            )),
        }
    }
}

/// A table in the lines of a text.
struct Table {
    width: usize,
    begin: usize,
    has_units: bool,
}

impl Table {
    /// The first rows of one width between these separators, with the heading above them.
    fn find(text: &str, separator: Option<u8>) -> Option<Self> {
        // A value may have either decimal mark.
        let mut fields = Fields::new(Dialect {
            separator,
            decimal_comma: false,
        });
        let lines: Vec<(usize, Line)> = text
            .lines()
            .take(LOOKED_AT)
            .enumerate()
            .filter(|(_, line)| !is_remark(line))
            .map(|(number, line)| (number, Line::new(fields.split(line).iter())))
            .collect();
        let is_row = |line: &Line, width: usize| line.width == width && line.is_row();
        let first = (0..lines.len()).find(|at| {
            let width = lines[*at].1.width;
            let next = lines.iter().skip(*at).take(TELLING);
            let rows = next.filter(|(_, line)| is_row(line, width)).count();
            rows == TELLING
        })?;
        let width = lines[first].1.width;
        let above = |by: usize| {
            let line = &lines.get(first.checked_sub(by)?)?.1;
            (line.width == width).then_some(line)
        };
        // Remarks belong to the table, whether a heading follows or not.
        let begin_of = |by: usize| match first - by {
            0 => 0,
            at => lines[at].0,
        };
        // A row that cannot be read is no preface: its error names it.
        if above(1).is_some_and(|line| line.numbers > 0) {
            return None;
        }
        // Nor are rows of another width, or a heading further up.
        let is_of_table =
            |(at, line): (usize, &Line)| line.is_row() || (at + 2 < first && line.width == width);
        let words = lines.iter().take(first).map(|(_, line)| line);
        if words.enumerate().any(is_of_table) {
            return None;
        }
        let names = above(2).filter(|line| line.numbers == 0);
        let (by, has_units) = match (above(1), names) {
            (Some(units), Some(names)) if names.distinct >= units.distinct => (2, true),
            (heading, _) => (usize::from(heading.is_some()), false),
        };
        Some(Self {
            width,
            begin: begin_of(by),
            has_units,
        })
    }
}

/// Fields of a line.
struct Line {
    width: usize,
    numbers: usize,
    values: usize,
    /// Number of different fields.
    distinct: usize,
}

impl Line {
    fn new<'f>(fields: impl Iterator<Item = &'f str>) -> Self {
        let mut all: Vec<&str> = fields.collect();
        // Some programs end each line with a separator.
        if all.len() > 1 && all.last().is_some_and(|last| last.is_empty()) {
            all.pop();
        }
        let values = all.iter().filter(|f| is_value(f)).count();
        let numbers = all.iter().filter(|f| !f.is_empty() && is_value(f)).count();
        let width = all.len();
        all.sort_unstable();
        all.dedup();
        Self {
            width,
            numbers,
            values,
            distinct: all.len(),
        }
    }

    const fn is_row(&self) -> bool {
        self.values == self.width && self.numbers > 0 && self.width > 1
    }
}

#[cfg(test)]
#[path = "preface_tests.rs"]
mod tests;
