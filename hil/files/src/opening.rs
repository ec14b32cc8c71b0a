//! The beginning of a table: remarks, a heading or none, and the first rows, by which the rest is read.

use std::io::Read;

use super::clock::is_unit_of_time;
use super::dialect::{Dialect, Fields, Writing, is_remark, is_value};
use super::error::FileError;
use super::format::Format;
use super::preface::Preface;
use super::reading::Lines;

/// Rows of a table's beginning that are looked at.
const LOOKED_AT: usize = 64;

/// Beginning of a table.
#[derive(Debug)]
pub(super) struct Opening {
    /// The first line that is no remark: its number, from 1.
    pub(super) line: usize,
    first: String,
    /// The names of the columns; none where there is no heading.
    names: Option<Vec<String>>,
    /// `true` where the first line is a row.
    is_row: bool,
    /// Fields of the first line.
    pub(super) width: usize,
    pub(super) dialect: Dialect,
    /// The first rows.
    pub(super) rows: Vec<Vec<String>>,
    /// Remark on lines before the heading.
    pub(super) note: Option<String>,
}

impl Opening {
    /// Looks at the beginning of a text, up to its heading or first row. The heading is the first line, if one of its fields is no
    /// value, or the last remark before it, if it has as many fields and none is a value, as `numpy.savetxt` writes one. Other lines
    /// before it are passed over, and units in a line below it join the names.
    ///
    /// # Errors
    /// A text of another format, and an empty one.
    pub(super) fn read<R: Read>(lines: &mut Lines<R>, known: Writing) -> Result<Self, FileError> {
        let format = lines.format()?.filter(|f| *f != Format::Csv);
        let start = lines.start()?.to_owned();
        // Lines such as `rate = 100` are settings only where no table follows.
        let is_text = matches!(format, None | Some(Format::Toml));
        let preface = is_text.then(|| Preface::find(&start, known)).flatten();
        if let Some(format) = format.filter(|_| preface.is_none()) {
            let label = lines.label();
            return Err(FileError::whole(label, "a recording (CSV)", format.noun()));
        }
        let preface = preface.unwrap_or_default();
        let note = preface.note(&start);
        let start = preface.rest(&start);
        for _ in 0..preface.lines {
            lines.advance()?;
        }
        let known = Writing {
            separator: preface.separator.map(Some).or(known.separator),
            ..known
        };
        let dialect = Dialect::guess(&start, known);
        let mut fields = Fields::new(dialect);
        let (remark, line, first) = first_line(lines)?;
        let row = fields.split(&first);
        let (is_row, count) = (row.iter().all(is_value), row.count());
        // One field more, an empty one, where each line ends with a separator.
        let width = count - usize::from(count > 1 && row.get(count - 1).is_empty());
        let mut names: Option<Vec<String>> = None;
        if !is_row {
            names = Some(row.iter().map(str::to_owned).collect());
        } else if !remark.is_empty() {
            let row = fields.split(&remark);
            if row.count() == count && row.iter().all(|name| !is_value(name)) {
                names = Some(row.iter().map(str::to_owned).collect());
            }
        }
        // Some programs end each line with a separator.
        if let Some(names) = &mut names
            && names.len() > 1
            && names.last().is_some_and(String::is_empty)
        {
            names.pop();
        }
        if preface.has_units {
            let (_, _, units) = first_line(lines)?;
            let units = fields.split(&units);
            let names = names.iter_mut().flatten().zip(units.iter());
            names.for_each(|(name, unit)| join(name, unit));
        }
        let end = start.rfind('\n').unwrap_or(start.len());
        let whole = start.get(..end).unwrap_or_default().lines();
        let rows = whole
            .filter(|line| !is_remark(line))
            .skip(usize::from(!is_row));
        let rows = rows.take(LOOKED_AT);
        let rows = rows.map(|line| fields.split(line).iter().map(str::to_owned).collect());
        Ok(Self {
            rows: rows.collect(),
            line,
            first,
            names,
            is_row,
            width,
            dialect,
            note,
        })
    }

    /// The names of the columns; none where there is no heading.
    pub(super) fn headings(&self) -> Option<Vec<&str>> {
        let names = self.names.as_ref()?;
        Some(names.iter().map(String::as_str).collect())
    }

    /// The fields of the first line.
    pub(super) fn bare(&self) -> Vec<String> {
        let row: Vec<String> = Fields::new(self.dialect)
            .split(&self.first)
            .iter()
            .map(str::to_owned)
            .collect();
        row.into_iter().take(self.width).collect()
    }

    /// The first line where it is a row, and its number.
    pub(super) fn pending(&self) -> Option<(usize, String)> {
        self.is_row.then(|| (self.line, self.first.clone()))
    }
}

/// Adds a unit of times to the name of its column.
fn join(name: &mut String, unit: &str) {
    let unit = unit.trim_matches(['(', ')', '[', ']']);
    if is_unit_of_time(unit) {
        *name = format!("{name} ({unit})");
    }
}

/// The last remark before the first line that is none, and that line with its number.
fn first_line<R: Read>(lines: &mut Lines<R>) -> Result<(String, usize, String), FileError> {
    let mut remark = String::new();
    loop {
        match lines.advance()? {
            Some((_, text)) if is_remark(text) => {
                if !text.trim().is_empty() {
                    let text = text.trim().trim_start_matches(['#', '%', '/']);
                    remark = text.trim().to_owned();
                }
            }
            Some((number, text)) => return Ok((remark, number, text.to_owned())),
            None => {
                let found = "an empty file";
                return Err(FileError::whole(lines.label(), "a header and rows", found));
            }
        }
    }
}
