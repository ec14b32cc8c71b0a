//! Recorded taxels as a run takes them: whole tables of raw counts.

use std::path::Path;

use palpate_files::{Columns, FileError, MOST_VALUES, Rows, Take, Timing};
use palpate_run::TaxelTable;

use crate::progress::Progress;

/// How recordings of taxels are read: their times, and their columns where the header is not ours.
#[derive(Clone, Debug, Default)]
pub struct Reading {
    /// When rows came.
    pub timing: Timing,
    /// What the names of the columns begin with; none: `txl1_x` and so on.
    pub prefix: Option<String>,
}

impl Reading {
    /// Rows of our own header that come at this rate, Hz.
    #[must_use]
    pub fn at_rate(hz: f64) -> Self {
        let timing = Timing {
            rate_hz: Some(hz),
            ..Timing::default()
        };
        Self {
            timing,
            prefix: None,
        }
    }

    /// The columns that are taken.
    #[must_use]
    pub fn take<'a>(&'a self, columns: &'a Columns) -> Take<'a> {
        match self.prefix.as_deref() {
            Some(prefix) => Take::Counted(prefix, columns.count()),
            None => Take::Taxels(columns),
        }
    }
}

/// Reads a recording, and what is to be said of it.
///
/// # Errors
/// As [`Rows::open`] and [`Rows::advance`], and a recording that is too long.
pub fn read_taxel_csv(
    path: &Path,
    columns: &Columns,
    reading: &Reading,
) -> Result<(TaxelTable, Vec<String>), FileError> {
    let _shown = Progress::reading(path);
    let mut rows = Rows::open(path, reading.take(columns), Some(&reading.timing))?;
    let mut table = TaxelTable {
        time_us: Vec::new(),
        counts: Vec::new(),
        columns: columns.count(),
    };
    let mut row: Vec<u16> = Vec::new();
    while let Some(at) = rows.advance(&mut row)? {
        if table.counts.len() + row.len() > MOST_VALUES {
            return Err(rows.too_long(at.line));
        }
        table.time_us.push(at.time_us);
        table.counts.extend_from_slice(&row);
    }
    Ok((table, rows.notes()))
}
