//! Frames of a pressure map, a block of lines or a file each, as the text of a table: a row for each frame.
//!
//! Blocks stand between blank lines, remarks (`# New slice` of NumPy) or lines such as `Frame 2`. Tekscan's exports
//! have a header, which ends with `ASCII_DATA @@`, and `B` in cells without a sensor. A column is named by its cell,
//! `cell1` and so on, line by line.

use std::collections::BTreeSet;
use std::fs::File;
use std::path::{Path, PathBuf};

use super::columns::MOST_BEFORE;
use super::dialect::{Dialect, Fields, Writing, is_remark, is_value};
use super::error::FileError;
use super::made;
use super::order::number_in;
use super::reading::{Lines, entries, is_stream};
use super::taken::shown;

/// Bytes of a file's beginning in which two frames are looked for.
const LOOKED_AT: usize = 4 << 20;
/// Lines that tell the separator.
const TELLING: usize = 8;
/// First word of Tekscan's exports, and that of the last line of their header.
const TEKSCAN: [&str; 2] = ["DATA_TYPE", "ASCII_DATA"];
/// A cell of Tekscan's that holds no sensor.
const NO_SENSOR: &str = "B";

/// Shape of the frames of a recording.
#[derive(Clone, Debug)]
struct Shape {
    rows: usize,
    columns: usize,
    dialect: Dialect,
    /// Seconds from frame to frame, where the file says.
    step_s: Option<f64>,
    /// `true` for an export of Tekscan's.
    is_export: bool,
}

/// Reads a recording frame by frame.
#[derive(Debug)]
pub(super) struct Blocks {
    shape: Shape,
    lines: Lines<File>,
    /// Files with the frames that follow, where each has one of its own.
    files: std::vec::IntoIter<PathBuf>,
    fields: Fields,
    frames: u64,
    longest: usize,
    /// Cells without a sensor, by the first frame.
    absent: BTreeSet<usize>,
    note: String,
}

impl Blocks {
    /// Opens a recording whose frames are blocks of lines, or the files of a folder. None for a table with a row in each
    /// line. `count` is the number of readings that are wanted, 0 where it is not known; `stated` is the lines of a frame as a
    /// recipe states them; `longest` is the most bytes of a line.
    ///
    /// # Errors
    /// A file that cannot be read, and a folder whose first file holds no frame.
    pub(super) fn open(
        path: &Path,
        count: usize,
        stated: Option<usize>,
        longest: usize,
    ) -> Result<Option<Self>, FileError> {
        if stated == Some(1) || is_stream(path) {
            return Ok(None);
        }
        let open = |path: &Path| Lines::open(path, "a recording", longest);
        let label = path.display().to_string();
        let mut files = match path.is_dir() {
            true => files(path)?,
            false => vec![path.to_owned()],
        };
        let Some(first) = files.first() else {
            let found = "an empty folder";
            return Err(FileError::whole(label, "a file for each frame", found));
        };
        let found = Shape::find(&mut open(first)?, count, stated)?;
        let lines = open(first)?;
        let note = if path.is_dir() {
            let Some((shape, _)) = found.as_ref().filter(|(_, heights)| heights.len() == 1) else {
                let (label, found) = (first.display().to_string(), "another one");
                return Err(FileError::whole(label, "a frame of numbers", found));
            };
            let order = "in the order of the numbers in their names";
            format!(
                "{label}: a frame in each of {} files, {order}; {}",
                files.len(),
                shape.told()
            )
        } else {
            let is_telling = |shape: &Shape, heights: &[usize]| match heights {
                [first, second] if first == second && *first > 1 => true,
                _ => stated.is_some() || shape.is_export,
            };
            let Some((shape, _)) = found.as_ref().filter(|(s, heights)| is_telling(s, heights))
            else {
                return Ok(None);
            };
            format!("{label}: a frame in each block; {}", shape.told())
        };
        files.remove(0);
        Ok(found.map(|(shape, _)| Self {
            fields: Fields::new(shape.dialect),
            shape,
            lines,
            files: files.into_iter(),
            frames: 0,
            longest,
            absent: BTreeSet::new(),
            note,
        }))
    }

    /// Remark on the frames.
    pub(super) fn note(&self) -> String {
        self.note.clone()
    }

    /// Adds the cells of the next frame, a comma before each; false at the end.
    fn frame(&mut self, cells: &mut Vec<u8>) -> Result<bool, FileError> {
        let Shape { rows, columns, .. } = self.shape;
        let mut row = 0;
        while row < rows {
            let label = self.lines.label().to_owned();
            let wrong = |line, expected: String, found: String| FileError {
                line,
                ..FileError::whole(label.clone(), expected, found)
            };
            let short = |line| wrong(line, format!("{rows} lines of a frame"), row.to_string());
            let Some((number, line)) = self.lines.advance()? else {
                if row > 0 {
                    return Err(short(None));
                }
                let Some(next) = self.files.next() else {
                    return Ok(false);
                };
                self.lines = Lines::open(&next, "a frame", self.longest)?;
                continue;
            };
            if !is_row(line) {
                match (row, line.trim() == "@@") {
                    (0, true) => return Ok(false),
                    (0, false) => continue,
                    _ => return Err(short(Some(number))),
                }
            }
            let fields = self.fields.split(line);
            if !fields.has_width(columns) {
                let expected = format!("{columns} numbers as in the first line");
                return Err(wrong(Some(number), expected, fields.count().to_string()));
            }
            for (column, field) in fields.iter().take(columns).enumerate() {
                let cell = row * columns + column;
                if field == NO_SENSOR && self.frames == 0 {
                    self.absent.insert(cell);
                } else if !self.absent.contains(&cell) {
                    if field.is_empty() || !is_value(field) {
                        let mut error = wrong(Some(number), "a number".into(), shown(field));
                        error.key = Some(format!("column {}", column + 1));
                        return Err(error);
                    }
                    cells.push(b',');
                    cells.extend(field.bytes());
                }
            }
            row += 1;
        }
        Ok(true)
    }
}

impl made::Lines for Blocks {
    fn add(&mut self, text: &mut Vec<u8>) -> Result<bool, FileError> {
        let mut cells = Vec::new();
        if !self.frame(&mut cells)? {
            return Ok(false);
        }
        let mut line = |time: String, cells: &[u8]| {
            let begin = if self.shape.step_s.is_some() {
                text.extend(time.bytes());
                0
            } else {
                1 // the comma before the first cell
            };
            text.extend_from_slice(cells.get(begin..).unwrap_or_default());
            text.push(b'\n');
        };
        if self.frames == 0 {
            let all = 0..self.shape.rows * self.shape.columns;
            let kept = all.filter(|cell| !self.absent.contains(cell));
            let names: String = kept.map(|cell| format!(",cell{}", cell + 1)).collect();
            line("time_us".into(), names.as_bytes());
        }
        // Frame numbers are far below 2^53.
        let us = self.shape.step_s.unwrap_or(0.0) * 1e6 * self.frames as f64;
        line(format!("{us:.0}"), &cells);
        self.frames += 1;
        Ok(true)
    }
}

impl Shape {
    /// The shape of the frames at the beginning of a text, and the lines of its first two blocks. None where a line holds
    /// other words, or a whole row of `count` readings.
    fn find(
        lines: &mut Lines<File>,
        count: usize,
        stated: Option<usize>,
    ) -> Result<Option<(Self, Vec<usize>)>, FileError> {
        let (mut heights, mut height, mut bytes) = (Vec::new(), 0, 0);
        let (mut telling, mut shape): (Vec<String>, Option<Self>) = (Vec::new(), None);
        let (mut step_s, mut is_export) = (None, false);
        let mut is_first = true;
        while let Some((_, line)) = lines.advance()? {
            bytes += line.len();
            if line.starts_with(TEKSCAN[0]) && is_first {
                is_export = true;
                step_s = step_of(lines)?;
            } else if is_row(line) {
                height += 1;
                if telling.len() < TELLING {
                    telling.push(line.to_owned());
                    let may_differ = is_export || stated.is_some();
                    shape = Self::of_lines(&telling, may_differ);
                    let width = shape.as_ref().map_or(0, |shape| shape.columns);
                    let is_whole = count > 0 && (count..=count + MOST_BEFORE).contains(&width);
                    if is_whole && telling.len() > 1 && !is_export {
                        return Ok(None);
                    }
                }
            } else if !is_between(line) {
                return Ok(None);
            } else if height > 0 {
                heights.push(std::mem::take(&mut height));
            }
            is_first = false;
            let is_stated = stated.is_some() && telling.len() == TELLING;
            if heights.len() == 2 || is_stated || bytes > LOOKED_AT {
                break;
            }
        }
        if height > 0 {
            heights.push(height);
        }
        let rows = stated.or_else(|| heights.first().copied());
        let shape = shape.zip(rows).map(|(shape, rows)| Self {
            rows,
            step_s,
            is_export,
            ..shape
        });
        Ok(shape.map(|shape| (shape, heights)))
    }

    /// The shape of lines that hold more than one number. None where they do not hold as many each, unless they may differ: then
    /// the first counts.
    fn of_lines(lines: &[String], may_differ: bool) -> Option<Self> {
        let dialect = Dialect::guess(&(lines.join("\n") + "\n"), Writing::default());
        let mut fields = Fields::new(dialect);
        let first = fields.split(lines.first()?);
        let count = first.count();
        let columns = count - usize::from(count > 1 && first.get(count - 1).is_empty());
        let mut all = lines.iter();
        let is_even = may_differ || all.all(|line| fields.split(line).has_width(columns));
        (is_even && columns > 1).then_some(Self {
            rows: 0,
            columns,
            dialect,
            step_s: None,
            is_export: false,
        })
    }

    fn told(&self) -> String {
        let step = self
            .step_s
            .map_or_else(String::new, |s| format!(", and {s} s from frame to frame"));
        format!(
            "cells are numbered through its {} lines of {} numbers, the first line on top{step}",
            self.rows, self.columns
        )
    }
}

/// The seconds from frame to frame in Tekscan's header, which is read to its end.
fn step_of(lines: &mut Lines<File>) -> Result<Option<f64>, FileError> {
    let mut step_s = None;
    while let Some((_, line)) = lines.advance()? {
        let mut words = line.split([' ', '\t', ',']);
        match words.next() {
            Some("SECONDS_PER_FRAME") => {
                let seconds: Option<f64> = words.next().and_then(|word| word.parse().ok());
                step_s = seconds.filter(|s| s.is_finite() && *s > 0.0);
            }
            Some(word) if word == TEKSCAN[1] => break,
            _ => {}
        }
    }
    Ok(step_s)
}

/// Tells whether a line holds cells.
fn is_row(line: &str) -> bool {
    let line = line.trim_start();
    let is_cell = line.starts_with(|c: char| c.is_ascii_digit() || "-+.\"".contains(c));
    is_cell || line.split([',', ' ', '\t', ';']).next() == Some(NO_SENSOR)
}

/// Tells whether a line stands between frames.
fn is_between(line: &str) -> bool {
    let start = line.trim_start().get(..5);
    is_remark(line)
        || line.trim() == "@@"
        || start.is_some_and(|word| word.eq_ignore_ascii_case("frame"))
}

/// The files of a folder, in the order of the numbers in their names.
fn files(folder: &Path) -> Result<Vec<PathBuf>, FileError> {
    let mut files = entries(folder)?;
    files.retain(|path| path.is_file());
    files.sort_by_cached_key(|path| {
        let name = path.file_stem().unwrap_or_default().to_string_lossy();
        (number_in(&name), name.into_owned())
    });
    Ok(files)
}

#[cfg(test)]
#[path = "blocks_tests.rs"]
mod tests;
