//! Recorded taxels as a run takes them: a short recording as a whole table of raw counts, a long one row by row from
//! its file, once per pass.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use palpate_files::{
    Columns, FileError, Input, MOST_VALUES, RecipePlan, RowAt, Rows, Take, Timing, is_stream,
};
use palpate_run::{Failure, NextRow, RowSource, TaxelTable};

/// Most values of a file that are held, 2 bytes each: a quarter of an hour of 48 columns at 100 Hz.
const HELD: usize = 4 << 20;

use crate::progress::Progress;

/// Format of recordings of taxels: their times, and their columns where the header is not ours.
#[derive(Clone, Debug, Default)]
pub struct Reading {
    /// Times of the rows.
    pub timing: Timing,
    /// Beginning of the columns' names; `None` for `txl1_x` and so on.
    pub prefix: Option<String>,
    /// A recipe for the whole skin, in place of a prefix.
    pub recipe: Option<RecipePlan>,
}

impl Reading {
    /// Columns of the recording that are taken.
    #[must_use]
    pub fn take<'a>(&'a self, columns: &'a Columns) -> Take<'a> {
        match (&self.recipe, self.prefix.as_deref()) {
            (Some(recipe), _) => Take::Recipe(recipe),
            (None, Some(prefix)) => Take::Counted(prefix, columns.count()),
            (None, None) => Take::Taxels(columns),
        }
    }
}

/// Reads a recording of taxels through, and what is to be said of it. A file that is too long to be held is read again for every
/// pass; a stream cannot be.
///
/// # Errors
/// The errors of [`Rows::open`] and [`Rows::advance`], and a stream that is too long.
pub fn read_taxel_csv(
    path: &Path,
    columns: &Columns,
    reading: &Reading,
) -> Result<(Arc<dyn RowSource>, Vec<String>), FileError> {
    let _shown = Progress::reading(path);
    let most = if is_stream(path) { MOST_VALUES } else { HELD };
    read_holding(path, columns, reading, most)
}

fn read_holding(
    path: &Path,
    columns: &Columns,
    reading: &Reading,
    most: usize,
) -> Result<(Arc<dyn RowSource>, Vec<String>), FileError> {
    let mut rows = Rows::open(path, reading.take(columns), Some(&reading.timing))?;
    let mut held = Some(TaxelTable {
        time_us: Vec::new(),
        counts: Vec::new(),
        columns: columns.count(),
    });
    let mut row: Vec<u16> = Vec::new();
    let (mut first, mut last) = (None, 0);
    while let Some(at) = rows.advance(&mut row)? {
        last = at.time_us;
        first.get_or_insert(last);
        let Some(table) = &mut held else { continue };
        if table.counts.len() + row.len() > most {
            if is_stream(path) {
                return Err(FileError {
                    line: Some(at.line),
                    ..FileError::whole(
                        path.display().to_string(),
                        format!(
                            "a pipe of at most {} rows, which are held",
                            rows.count() - 1
                        ),
                        "more (save it as a file, which is read as it is played)",
                    )
                });
            }
            held = None;
            continue;
        }
        table.time_us.push(last);
        table.counts.extend_from_slice(&row);
    }
    let notes = rows.notes();
    let source: Arc<dyn RowSource> = match held {
        Some(table) => Arc::new(table),
        None => Arc::new(LongTable {
            path: path.into(),
            columns: columns.clone(),
            reading: reading.clone(),
            frames: rows.count(),
            span_us: last - first.unwrap_or(last),
        }),
    };
    Ok((source, notes))
}

/// A recording that was read through once, and is read again for every pass.
#[derive(Debug)]
struct LongTable {
    path: PathBuf,
    columns: Columns,
    reading: Reading,
    frames: usize,
    span_us: u64,
}

impl RowSource for LongTable {
    fn columns(&self) -> usize {
        self.columns.count()
    }

    fn frames(&self) -> usize {
        self.frames
    }

    fn span_us(&self) -> u64 {
        self.span_us
    }

    fn rows(&self) -> Result<Box<dyn NextRow + '_>, Failure> {
        let take = self.reading.take(&self.columns);
        Ok(Box::new(FromFile {
            rows: Rows::open(&self.path, take, Some(&self.reading.timing))?,
        }))
    }
}

/// The rows of a file.
struct FromFile {
    rows: Rows<Input>,
}

impl NextRow for FromFile {
    fn next_row(&mut self, counts: &mut Vec<u16>) -> Result<Option<u64>, Failure> {
        let at: Option<RowAt> = self.rows.advance(counts)?;
        Ok(at.map(|at| at.time_us))
    }
}

#[cfg(test)]
#[path = "taxel_csv_tests.rs"]
mod tests;
