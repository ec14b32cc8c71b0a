//! Tables of numbers row by row, as text or as arrays: recordings of taxels, ours and those of other programs.

use std::fs::File;
use std::io::Read;
use std::path::Path;

use super::arrays;
use super::bare::Tail;
use super::blocks::Blocks;
use super::clock::{Beginning, Clock, Timing};
use super::columns::{MOST_BEFORE, Take};
use super::dialect::{Fields, Row, Writing};
use super::error::FileError;
use super::format::Format;
use super::gain::Gain;
use super::made::Made;
use super::messages;
use super::number::Number;
use super::objects;
use super::opening::Opening;
use super::reading::{LONGEST_LINE, Lines, MOST_VALUES, Text, format_of, open};
use super::taken::{Taken, Wrong, shown};
use super::times::{OutOfTime, TimeUnit, Times};
use super::turns::{Frame, Parts};

/// Bytes that a table is read from.
pub type Input = Box<dyn Read + Send>;

/// A table, row by row.
#[derive(Debug)]
pub struct Rows<R> {
    /// Name of the file in errors.
    label: String,
    lines: Lines<R>,
    taken: Vec<Taken>,
    clock: Clock,
    times: Times,
    /// True if the unit of the times was stated, and so needs no look.
    stated: bool,
    /// Fields per row.
    width: usize,
    fields: Fields,
    /// The columns taken, where they are counts at the end of a row.
    tail: Option<Tail>,
    /// A first line that is data already, and its number.
    pending: Option<(usize, String)>,
    count: usize,
    /// Remarks on how columns and times were found, where the file names them in another way than ours do.
    notes: Vec<String>,
    /// Sensors whose rows take turns.
    parts: Option<Parts>,
}

/// Line and time of a row.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct RowAt {
    /// Line of the file, from 1.
    pub line: usize,
    /// Microseconds; 0 where times are of no interest.
    pub time_us: u64,
}

impl Rows<Input> {
    /// Opens a file: text, JSON Lines, an array of NumPy or MATLAB, messages; or a folder with a frame in each file.
    ///
    /// # Errors
    /// A file that cannot be read or holds no table, wrong columns, no times where they are wanted.
    pub fn open(path: &Path, take: Take<'_>, timing: Option<&Timing>) -> Result<Self, FileError> {
        let count = take.count().unwrap_or(0);
        let (text, note) = table(path, count, timing, take.frame_lines())?;
        let mut rows = Self::over(text, take, timing)?;
        rows.notes.extend(note);
        Ok(rows)
    }
}

/// A file as the text of a table, and what is to be said of it.
fn table(
    path: &Path,
    count: usize,
    timing: Option<&Timing>,
    frame_lines: Option<usize>,
) -> Result<(Text<Input>, Option<String>), FileError> {
    let label = path.display().to_string();
    // A million taxels have a header of 40 MB.
    let longest = count.saturating_mul(40).max(LONGEST_LINE);
    let (input, note): (Input, _) = match format_of(path) {
        Some(Format::Numpy | Format::Npz | Format::Matlab) => {
            let rest_rows = timing.map_or(0, |timing| timing.rest_rows);
            let array = arrays::read(path, count, rest_rows)?;
            let note = array.note();
            (Box::new(Made::new(array)), note)
        }
        Some(Format::Json) => {
            let file = open(path, "a readable file")?;
            let objects = objects::Objects::new(file, &label);
            (Box::new(Made::new(objects)), None)
        }
        Some(Format::Mcap) => {
            let topic = timing.and_then(|timing| timing.topic.as_deref());
            let messages = messages::Messages::open(path, topic)?;
            let note = messages.note();
            (Box::new(Made::new(messages)), Some(note))
        }
        _ => {
            let plain = (!path.is_dir()).then(|| text(path)).transpose()?;
            let blocks = Blocks::open(path, count, frame_lines, longest)?;
            match (blocks, plain) {
                (Some(blocks), _) => {
                    let note = blocks.note();
                    (Box::new(Made::new(blocks)), Some(note))
                }
                (None, Some(plain)) => (Box::new(plain), None),
                (None, None) => (Box::new(text(path)?), None),
            }
        }
    };
    Ok((Text::new(label, input, longest).waiting(), note))
}

/// The beginning of a file's table, and what is to be said of the file.
///
/// # Errors
/// The errors of [`Rows::open`].
pub(super) fn opened(path: &Path, timing: &Timing) -> Result<(Opening, Option<String>), FileError> {
    let (text, note) = table(path, 0, Some(timing), None)?;
    Ok((
        Opening::read(&mut Lines::over(text), Writing::default())?,
        note,
    ))
}

/// A file of text.
fn text(path: &Path) -> Result<File, FileError> {
    if let Some(format) = format_of(path).filter(|f| !f.is_text()) {
        let label = path.display().to_string();
        return Err(FileError::whole(label, "a recording", format.noun()));
    }
    open(path, "a readable file")
}

impl<R: Read> Rows<R> {
    /// Reads a table from any text.
    ///
    /// # Errors
    /// The errors of [`Rows::open`].
    pub fn over(text: Text<R>, take: Take<'_>, timing: Option<&Timing>) -> Result<Self, FileError> {
        let mut lines = Lines::over(text);
        let label = lines.label().to_owned();
        let head = Opening::read(&mut lines, take.writing())?;
        let at = |(key, expected, found): Wrong| FileError {
            path: label.clone(),
            line: Some(head.line),
            key,
            expected,
            found,
        };
        let (names, width) = (head.headings(), head.width);
        let has_heading = names.is_some();
        let count = take.count().unwrap_or(width);
        let table = Beginning {
            names: names.as_deref(),
            rows: &head.rows,
            before: width
                .checked_sub(count)
                .filter(|n| *n <= MOST_BEFORE)
                .unwrap_or(0),
        };
        let clock = timing.map_or(Ok((Clock::None, None)), |t| t.clock(&table));
        let (clock, clock_note) = clock.map_err(at)?;
        let bare = head.bare();
        let bare: Vec<&str> = bare.iter().map(String::as_str).collect();
        let first = names.as_deref().unwrap_or(&bare);
        let (mut taken, order_note) = take
            .choose(first, has_heading, &clock.places())
            .map_err(at)?;
        if matches!((&clock, timing), (Clock::None, Some(_))) {
            let expected = "a first column time_us, or a rate (--rate HZ), or --time COLUMN:UNIT";
            return Err(at((None, expected.into(), "neither".into())));
        }
        let gain = timing.and_then(|timing| timing.gain);
        if let (Take::Taxels(_), None) = (take, gain) {
            let places: Vec<usize> = taken.iter().map(|t| t.place).collect();
            Gain::needless(&head.rows, &places)
                .map_err(|(expected, found)| at((None, expected, found)))?;
        }
        if gain.is_some() {
            taken.iter_mut().for_each(|column| column.gain = gain);
        }
        let parts = take.turns(first, has_heading).map_err(at)?.map(Parts::new);
        let tail = match parts {
            None => Tail::new(head.dialect, &taken, first.len()),
            Some(_) => None,
        };
        let notes = [head.note.clone(), order_note, clock_note];
        let notes = notes.into_iter().flatten();
        let is_plain = matches!(&clock, Clock::Column(_, column) if column.unit == TimeUnit::Us);
        Ok(Self {
            notes: notes.map(|note| format!("{label}: {note}")).collect(),
            stated: !is_plain || timing.is_none_or(|t| t.column.is_some()),
            tail,
            taken,
            clock,
            times: Times::new(timing.is_some_and(|t| t.split_jumps)),
            width: first.len(),
            pending: head.pending(),
            fields: Fields::new(head.dialect),
            count: 0,
            parts,
            label,
            lines,
        })
    }

    /// The next row: its values in place of those in `values`; none at the end. Where sensors take turns, a row is made of
    /// one of each.
    ///
    /// # Errors
    /// The first line that is no row, with its column; a table without a row.
    pub fn advance<V: Number>(&mut self, values: &mut Vec<V>) -> Result<Option<RowAt>, FileError> {
        let mut frame = Frame::new(self.parts.as_ref());
        loop {
            values.clear();
            let pending = self.pending.take();
            let (line, text) = match &pending {
                Some((line, text)) => (*line, text.as_str()),
                None => match self.lines.next_row()? {
                    Some(row) => row,
                    None => return self.ended(frame.begun()),
                },
            };
            let before = self.tail.and_then(|tail| tail.read(text, values));
            let row = self.fields.split(before.unwrap_or(text));
            let wrong = |(key, expected, found): Wrong| FileError {
                path: self.label.clone(),
                line: Some(line),
                key,
                expected,
                found,
            };
            let columns = match &mut self.parts {
                None => Some(0..self.taken.len()),
                Some(parts) => parts.columns(row),
            };
            let Some(columns) = columns else { continue };
            if before.is_none() {
                read_row(row, self.width, &self.taken[columns], values).map_err(wrong)?;
            }
            if let Some(parts) = &mut self.parts
                && !frame.add(parts, values)
            {
                continue;
            }
            let time_us = match &self.clock {
                Clock::None => 0,
                // Frame numbers are far below 2^53, so the product is exact enough to round.
                Clock::Rate(rate) => libm::round(self.count as f64 * 1e6 / rate) as u64,
                clock => {
                    let us = clock.micros(row, self.stated).map_err(wrong)?;
                    let is_coarse = self.stated
                        && clock
                            .counted()
                            .is_some_and(|(_, unit)| unit != TimeUnit::Us);
                    let next = self.times.next_row((&self.label, line), us, is_coarse);
                    next.map_err(|OutOfTime { expected, found }| {
                        let place = clock.counted().map_or(0, |(place, _)| place);
                        let found = found.unwrap_or_else(|| shown(row.get(place)));
                        wrong((Some(clock.key()), expected, found))
                    })?
                }
            };
            self.count += 1;
            if !self.stated {
                self.look_at_times(false)?;
            }
            return Ok(Some(RowAt { line, time_us }));
        }
    }

    /// The end of the table.
    fn ended(&mut self, is_cut: bool) -> Result<Option<RowAt>, FileError> {
        if self.count == 0 {
            let (expected, found) = match &self.parts {
                Some(parts) => (parts.expected(), parts.found()),
                None => ("at least one row".to_owned(), "a header alone".to_owned()),
            };
            return Err(FileError::whole(self.lines.label(), expected, found));
        }
        if let Some(parts) = &mut self.parts {
            parts.is_cut |= is_cut;
        }
        self.look_at_times(true)?;
        Ok(None)
    }

    /// Reads all further rows, their values one after another.
    ///
    /// # Errors
    /// The errors of [`Rows::advance`], and more than [`MOST_VALUES`].
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

    /// The error for a row that is one too many.
    #[must_use]
    pub fn too_long(&self, line: usize) -> FileError {
        let expected = format!("at most {} rows", self.count - 1);
        FileError {
            line: Some(line),
            ..FileError::whole(self.lines.label(), expected, "more (cut the recording)")
        }
    }

    /// Refuses numbers that only look like microseconds, once, as soon as enough rows tell.
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

    /// Remarks on the file, once its end is reached.
    pub fn notes(&mut self) -> Vec<String> {
        let mut notes = std::mem::take(&mut self.notes);
        notes.extend(self.times.take_notes());
        notes.extend(self.lines.note());
        let said = self.parts.as_mut().map(Parts::notes).unwrap_or_default();
        notes.extend(
            said.into_iter()
                .map(|note| format!("{}: {note}", self.label)),
        );
        notes
    }
}

/// The values of a row.
fn read_row<V: Number>(
    row: Row<'_>,
    width: usize,
    taken: &[Taken],
    values: &mut Vec<V>,
) -> Result<(), Wrong> {
    for taken in taken {
        // The error of a row that is too short names its width.
        if taken.place < row.count() {
            values.push(number(row.get(taken.place), taken)?);
        }
    }
    if !row.has_width(width) {
        let expected = format!("{width} columns as in the header");
        return Err((None, expected, row.count().to_string()));
    }
    Ok(())
}

fn number<V: Number>(field: &str, taken: &Taken) -> Result<V, Wrong> {
    let read = match taken.gain {
        None => V::read(field),
        Some(gain) => field.parse().ok().and_then(|v| V::of_value(gain.counts(v))),
    };
    match read {
        Some(number) if taken.is_opposite => Ok(number.opposite()),
        Some(number) => Ok(number),
        None => {
            let gain = taken.gain.map(Gain::range);
            let expected = gain.unwrap_or_else(|| V::EXPECTED.to_owned());
            Err((Some(taken.key()), expected, shown(field)))
        }
    }
}

#[cfg(test)]
#[path = "rows_tests.rs"]
mod tests;
