//! A table that grows row by row, so that what ends a sweep costs the runs under way alone.

use std::fs::{File, OpenOptions, TryLockError};
use std::io::Write;
use std::path::{Path, PathBuf};

use palpate_files::{FileError, Format, read_text};
use palpate_records::runs::{RunRow, RunTable, TableForm};
use palpate_run::{Failure, damaged};

use palpate_live::output::{Outputs, write_file};

/// Most bytes of a table: some millions of rows.
const MOST: u64 = 2 << 30;

/// The form of a table by the ending of its name.
///
/// # Errors
/// [`Failure::Input`] for another ending.
pub fn form_of(path: &Path) -> Result<TableForm, Failure> {
    match path.extension().and_then(|e| e.to_str()) {
        Some("csv") => Ok(TableForm::Csv),
        Some("jsonl") => Ok(TableForm::Lines),
        _ => Err(Failure::Input(format!(
            "{}: expected a name that ends in .csv or .jsonl (a row per line)",
            path.display()
        ))),
    }
}

/// Reads a table of a sweep.
///
/// # Errors
/// A file that cannot be read, and the first line that is no row.
pub fn read_table(path: &Path) -> Result<RunTable, FileError> {
    let text = read_text(path, "a table of a sweep", MOST)?;
    RunTable::read(&text).map_err(|damage| damaged(path.display().to_string(), damage))
}

/// The file of a sweep that runs. No other one writes to it.
#[derive(Debug)]
pub struct Growing {
    path: PathBuf,
    form: TableForm,
    head: String,
    file: File,
}

impl Growing {
    /// Opens or makes the table of a sweep over these keys, and says which rows it has. A last line that was cut off
    /// goes. With `outputs.force` what is there and no table of this sweep goes too.
    ///
    /// # Errors
    /// [`Failure::Input`] for a file that is none of this sweep's, or that another sweep is writing;
    /// [`Failure::Write`] for one that cannot be written.
    pub fn open<'a>(
        path: &Path,
        swept: impl Iterator<Item = &'a str>,
        outputs: Outputs<'_>,
        is_wanted: impl Fn(&RunRow) -> bool,
    ) -> Result<(Self, Vec<RunRow>), Failure> {
        let form = form_of(path)?;
        Self::check(path, outputs)?;
        let bad = |expected: &str, found: String| {
            Failure::Input(format!(
                "{}: expected {expected}, found {found}",
                path.display()
            ))
        };
        let is_new = !path.exists();
        let file = OpenOptions::new()
            .append(true)
            .create(true)
            .open(path)
            .map_err(Failure::written(path))?;
        // Where a file system has no locks, the user has to see to it.
        if matches!(file.try_lock(), Err(TryLockError::WouldBlock)) {
            return Err(bad(
                "a table of its own",
                "one that another `hil sweep` is writing".into(),
            ));
        }
        let head = form.head(swept);
        let mut growing = Self {
            path: path.to_path_buf(),
            form,
            head,
            file,
        };
        let table = match read_table(path) {
            Ok(table) => table,
            Err(_) if outputs.force => RunTable::default(),
            Err(error) => return Err(error.into()),
        };
        let others = table.rows.iter().filter(|row| !is_wanted(row)).count();
        if others > 0 && !outputs.force {
            return Err(bad(
                "rows of this sweep, scene, bench and version; --force drops others",
                format!("{others} of {} rows of another", table.rows.len()),
            ));
        }
        let rows: Vec<RunRow> = table.rows.into_iter().filter(is_wanted).collect();
        if is_new || table.whole == 0 {
            growing.file.set_len(0).map_err(Failure::written(path))?;
            let head = growing.head.clone();
            growing.append(&head)?;
        } else {
            // What is dropped by force is gone with the last line; until then the reader skips it again.
            let kept = growing.file.set_len(table.whole as u64);
            kept.map_err(Failure::written(path))?;
        }
        Ok((growing, rows))
    }

    /// Checks that the table may be written, before anything is computed.
    ///
    /// # Errors
    /// [`Failure::Input`] for what is no table.
    pub fn check(path: &Path, outputs: Outputs<'_>) -> Result<(), Failure> {
        if path.exists() && !path.is_file() {
            return Err(Failure::Input(format!(
                "{}: expected a file, which a sweep can go on with, found something else",
                path.display()
            )));
        }
        let format = match form_of(path)? {
            TableForm::Csv => Format::Csv,
            TableForm::Lines => Format::Json,
        };
        outputs.check(path, format)
    }

    /// Adds a row, in one write: a death in between leaves no half of one before it.
    ///
    /// # Errors
    /// [`Failure::Write`].
    pub fn add(&mut self, row: &RunRow) -> Result<(), Failure> {
        let line = self.form.line(row);
        self.append(&line)
    }

    fn append(&mut self, text: &str) -> Result<(), Failure> {
        let written = self.file.write_all(text.as_bytes());
        written.map_err(Failure::written(&self.path))
    }

    /// Puts these rows in place of all others, in this order.
    ///
    /// # Errors
    /// [`Failure::Write`].
    pub fn finish<'a>(self, rows: impl Iterator<Item = &'a RunRow>) -> Result<(), Failure> {
        write_file(&self.path, |out| {
            out.write_all(self.head.as_bytes())?;
            let mut lines = rows.map(|row| self.form.line(row));
            lines.try_for_each(|line| out.write_all(line.as_bytes()))
        })
    }
}
