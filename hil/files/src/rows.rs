//! Tables of numbers from CSV, row by row: recordings of taxels, ours and those of other programs.

use std::fs::File;
use std::io::Read;
use std::path::Path;

use super::columns::{TIMES, Take, Taken, Wrong, shown};
use super::error::FileError;
use super::format::Format;
use super::reading::{LONGEST_LINE, Lines, Text};
use super::times::{OutOfTime, TimeColumn, TimeUnit, Times};

/// Most values of a table that is held as a whole: six hours of 48 columns at 40 Hz.
pub const MOST_VALUES: usize = 40 << 20;

/// When the rows of a table came.
#[derive(Clone, Debug, Default)]
pub struct Timing {
    /// The column that says so; none: a first column `time_us`.
    pub column: Option<TimeColumn>,
    /// Rows per second where no column says so.
    pub rate_hz: Option<f64>,
    /// Whether jumps of the clock are taken out.
    pub split_jumps: bool,
}

/// A number that a table may hold.
pub trait Number: Sized {
    /// What messages call it.
    const EXPECTED: &'static str;

    /// The number in a field.
    fn read(field: &str) -> Option<Self>;
}

impl Number for u16 {
    const EXPECTED: &'static str = "a whole count from 0 to 65535";

    /// Also written as `49202.0`.
    fn read(field: &str) -> Option<Self> {
        if let Ok(count) = field.parse() {
            return Some(count);
        }
        let value: f64 = field.parse().ok()?;
        let whole = (0.0..=65_535.0).contains(&value) && (value - libm::floor(value)).abs() <= 0.0;
        // In range and whole: the cast changes nothing.
        whole.then_some(value as Self)
    }
}

impl Number for f32 {
    const EXPECTED: &'static str = "a finite number";

    fn read(field: &str) -> Option<Self> {
        field.parse().ok().filter(|v: &Self| v.is_finite())
    }
}

/// Where times come from.
#[derive(Clone, Debug)]
enum Clock {
    Column(usize, TimeColumn),
    Rate(f64),
    /// Times are of no interest.
    None,
}

/// A table, row by row.
#[derive(Debug)]
pub struct Rows<R> {
    lines: Lines<R>,
    taken: Vec<Taken>,
    clock: Clock,
    times: Times,
    /// Whether what the times count was stated, and so needs no look.
    stated: bool,
    /// Fields per row.
    width: usize,
    /// Those of the row that is read.
    fields: Fields,
    /// A first line that is data already.
    pending: Option<String>,
    count: usize,
}

/// Where and when a row stands.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct RowAt {
    /// Line of the file, from 1.
    pub line: usize,
    /// Microseconds; 0 where times are of no interest.
    pub time_us: u64,
}

impl Rows<File> {
    /// Opens a file.
    ///
    /// # Errors
    /// A file that cannot be read or is no CSV, wrong columns, no times where they are wanted.
    pub fn open(path: &Path, take: Take<'_>, timing: Option<&Timing>) -> Result<Self, FileError> {
        let count = match take {
            Take::Taxels(columns) => columns.count(),
            Take::Features { count, .. } | Take::Counted(_, count) => count,
            Take::Prefixed { .. } => 0,
        };
        // A million taxels have a header of 40 MB.
        let longest = count.saturating_mul(40).max(LONGEST_LINE);
        Self::over(Text::open(path, "a readable file", longest)?, take, timing)
    }
}

impl<R: Read> Rows<R> {
    /// A table from any text.
    ///
    /// # Errors
    /// As [`Rows::open`].
    pub fn over(text: Text<R>, take: Take<'_>, timing: Option<&Timing>) -> Result<Self, FileError> {
        let mut lines = Lines::over(text);
        let label = lines.label().to_owned();
        if let Some(format) = lines.format()?.filter(|f| *f != Format::Csv) {
            return Err(FileError::whole(&label, "a recording (CSV)", format.noun()));
        }
        let (line, first) = loop {
            match lines.advance()? {
                Some((_, text)) if text.trim().is_empty() => {}
                Some((number, text)) => break (number, text.to_owned()),
                None => {
                    let found = "an empty file";
                    return Err(FileError::whole(label, "a header and rows", found));
                }
            }
        };
        let at = |(key, expected, found): Wrong| FileError {
            path: label.clone(),
            line: Some(line),
            key,
            expected,
            found,
        };
        let record = Fields::of(&first);
        let fields: Vec<&str> = record.iter().collect();
        let header = fields.iter().any(|field| f32::read(field).is_none());
        let clock = timing.map_or(Ok(Clock::None), |t| t.clock(&fields));
        let clock = clock.map_err(at)?;
        let own = match &clock {
            Clock::Column(place, _) => Some(*place),
            _ => None,
        };
        let taken = take.of(&fields, header, own).map_err(at)?;
        if matches!((&clock, timing), (Clock::None, Some(_))) {
            let expected = "a first column time_us, or a rate (--rate HZ), or --time COLUMN:UNIT";
            return Err(at((None, expected.into(), "neither".into())));
        }
        Ok(Self {
            taken,
            clock,
            times: Times::new(timing.is_some_and(|t| t.split_jumps)),
            stated: timing.is_none_or(|t| t.column.is_some()),
            width: fields.len(),
            fields: Fields::none(),
            pending: (!header).then(|| first.clone()),
            count: 0,
            lines,
        })
    }

    /// The next row: its values in place of those in `values`; none at the end.
    ///
    /// # Errors
    /// The first line that is no row, with its column; a table without a row.
    pub fn advance<V: Number>(&mut self, values: &mut Vec<V>) -> Result<Option<RowAt>, FileError> {
        values.clear();
        let label = self.lines.label().to_owned();
        let at = |line: usize, (key, expected, found): Wrong| FileError {
            path: label.clone(),
            line: Some(line),
            key,
            expected,
            found,
        };
        let pending = self.pending.take();
        let (line, text) = match &pending {
            Some(text) => (1, text.as_str()),
            None => loop {
                match self.lines.advance()? {
                    Some((_, text)) if text.trim().is_empty() => {}
                    Some(row) => break row,
                    None if self.count == 0 => {
                        let found = "a header alone";
                        return Err(FileError::whole(label, "at least one row", found));
                    }
                    None => {
                        self.look_at_times(true)?;
                        return Ok(None);
                    }
                }
            },
        };
        let wrong = |wrong: Wrong| at(line, wrong);
        let (mut time, mut next, mut width) = (None, 0, 0);
        self.fields.split(text);
        for (place, field) in self.fields.iter().enumerate() {
            width += 1;
            if matches!(&self.clock, Clock::Column(column, _) if *column == place) {
                time = Some(field);
            }
            // Columns are mostly taken in their order; the rest are looked up.
            if let Some(taken) = self.taken.get(next).filter(|t| t.place == place) {
                values.push(number(field, taken).map_err(wrong)?);
                next += 1;
            }
        }
        if width != self.width {
            let expected = format!("{} columns as in the header", self.width);
            return Err(wrong((None, expected, width.to_string())));
        }
        if next < self.taken.len() {
            *values = looked_up(&self.fields, &self.taken).map_err(wrong)?;
        }
        let time_us = match &self.clock {
            Clock::None => 0,
            // Frame numbers are far below 2^53, so the product is exact enough to round.
            Clock::Rate(rate) => libm::round(self.count as f64 * 1e6 / rate) as u64,
            Clock::Column(place, column) => {
                let field = time.unwrap_or_default();
                let key = Some(format!("column {} ({})", place + 1, column.name));
                let us = match self.stated {
                    true => column.unit.micros(field),
                    false => field.parse().ok(),
                };
                let noun = column.unit.noun();
                let whole = if self.stated { "" } else { "whole " };
                let expected = || format!("a {whole}number of {noun}");
                let us = us.ok_or_else(|| wrong((key.clone(), expected(), shown(field))))?;
                let place = format!("{label}:{line}");
                let late = |e: OutOfTime| {
                    wrong((key, e.expected, e.found.unwrap_or_else(|| shown(field))))
                };
                let next = match self.stated && column.unit != TimeUnit::Us {
                    true => self.times.coarse_row(&place, us),
                    false => self.times.row(&place, us),
                };
                next.map_err(late)?
            }
        };
        self.count += 1;
        self.look_at_times(false)?;
        Ok(Some(RowAt { line, time_us }))
    }

    /// All further rows, their values one after another.
    ///
    /// # Errors
    /// As [`Rows::advance`], and more than [`MOST_VALUES`].
    pub fn rest<V: Number>(&mut self) -> Result<Vec<V>, FileError> {
        let (mut all, mut row) = (Vec::new(), Vec::new());
        while let Some(at) = self.advance(&mut row)? {
            if all.len() + row.len() > MOST_VALUES {
                return Err(self.too_long(at.line));
            }
            all.append(&mut row);
        }
        Ok(all)
    }

    /// What is said of a row that is one too many.
    #[must_use]
    pub fn too_long(&self, line: usize) -> FileError {
        let expected = format!("at most {} rows", self.count - 1);
        FileError {
            line: Some(line),
            ..FileError::whole(self.lines.label(), expected, "more (cut the recording)")
        }
    }

    /// Refuses numbers that only look like microseconds, once, as soon as it can be told.
    fn look_at_times(&mut self, ended: bool) -> Result<(), FileError> {
        if self.stated || !(ended || self.times.is_telling()) {
            return Ok(());
        }
        self.stated = true;
        let Clock::Column(place, column) = &self.clock else {
            return Ok(());
        };
        match self.times.looks_like() {
            None => Ok(()),
            Some(looks) => Err(FileError {
                key: Some(format!("column {} ({})", place + 1, column.name)),
                ..FileError::whole(
                    self.lines.label(),
                    format!(
                        "microseconds (--time {}:us if they are, :ns if they are those)",
                        column.name
                    ),
                    format!("what looks like {looks}"),
                )
            }),
        }
    }

    /// Rows so far.
    #[must_use]
    pub const fn count(&self) -> usize {
        self.count
    }

    /// The names of the columns taken.
    pub fn names(&self) -> impl Iterator<Item = &str> {
        self.taken.iter().map(|t| t.name.as_str())
    }

    /// What is to be said of the file, once its end is reached.
    pub fn notes(&mut self) -> Vec<String> {
        let mut notes = self.times.take_notes();
        notes.extend(self.lines.note());
        notes
    }
}

/// The fields of a line, without quotes and the spaces around them: the same memory for all lines.
#[derive(Debug)]
struct Fields {
    reader: csv_core::Reader,
    text: Vec<u8>,
    ends: Vec<usize>,
    count: usize,
}

impl Fields {
    fn none() -> Self {
        Self {
            reader: csv_core::Reader::new(),
            text: Vec::new(),
            ends: Vec::new(),
            count: 0,
        }
    }

    fn of(line: &str) -> Self {
        let mut fields = Self::none();
        fields.split(line);
        fields
    }

    fn split(&mut self, line: &str) {
        // Fields are no longer than their line, and each but the first has a comma before it. There is room for one
        // more of either: the reader takes no end where there is none.
        let most = 2 + line.bytes().filter(|b| *b == b',').count();
        self.text.resize(self.text.len().max(line.len() + 1), 0);
        self.ends.resize(self.ends.len().max(most), 0);
        self.reader.reset();
        let (_, _, written, ended) =
            self.reader
                .read_record(line.as_bytes(), &mut self.text, &mut self.ends);
        // The end of the line is the end of the record.
        let (text, ends) = (&mut self.text[written..], &mut self.ends[ended..]);
        let (_, _, _, last) = self.reader.read_record(&[], text, ends);
        self.count = ended + last;
    }

    fn iter(&self) -> impl Iterator<Item = &str> {
        let ends = self.ends.get(..self.count).unwrap_or_default();
        let mut begin = 0;
        ends.iter().map(move |end| {
            let field = self.text.get(begin..*end).unwrap_or_default();
            begin = *end;
            // What was text is text without its quotes; those behind a space are quotes to people alone.
            let field = std::str::from_utf8(field).unwrap_or_default().trim();
            let quoted = field.strip_prefix('"').and_then(|f| f.strip_suffix('"'));
            quoted.unwrap_or(field)
        })
    }
}

/// The columns taken of a row, in whatever order they stand.
fn looked_up<V: Number>(fields: &Fields, taken: &[Taken]) -> Result<Vec<V>, Wrong> {
    let all: Vec<&str> = fields.iter().collect();
    let field = |t: &Taken| number(all.get(t.place).copied().unwrap_or_default(), t);
    taken.iter().map(field).collect()
}

fn number<V: Number>(field: &str, taken: &Taken) -> Result<V, Wrong> {
    V::read(field).ok_or_else(|| {
        let name = match taken.name.as_str() {
            "" => String::new(),
            name => format!(" ({name})"),
        };
        let key = format!("column {}{name}", taken.place + 1);
        (Some(key), V::EXPECTED.into(), shown(field))
    })
}

impl Timing {
    fn clock(&self, first: &[&str]) -> Result<Clock, Wrong> {
        if let Some(column) = &self.column {
            let place = first.iter().position(|field| *field == column.name);
            let place = place.ok_or_else(|| {
                let names = shown(&first.join(", "));
                (None, format!("a column {} (--time)", column.name), names)
            })?;
            return Ok(Clock::Column(place, column.clone()));
        }
        if first.first() == Some(&TIMES[0]) {
            let column = TimeColumn {
                name: TIMES[0].into(),
                unit: TimeUnit::Us,
            };
            return Ok(Clock::Column(0, column));
        }
        match self.rate_hz {
            Some(rate) if rate.is_finite() && rate > 0.0 => Ok(Clock::Rate(rate)),
            Some(rate) => Err((None, "a rate above 0 Hz".into(), rate.to_string())),
            None => Ok(Clock::None),
        }
    }
}

#[cfg(test)]
#[path = "rows_tests.rs"]
mod tests;
