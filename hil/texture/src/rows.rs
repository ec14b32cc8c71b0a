//! Recordings of sensors from CSV: any number of columns, any numbers that are finite; and the files of a folder.

use std::io::{self, Read};
use std::path::{Path, PathBuf};

use csv::{Position, ReaderBuilder, StringRecord, Trim};
use palpate_files::FileError;

/// Which columns of a recording are taken.
#[derive(Clone, Copy, Debug)]
pub enum Take<'a> {
    /// The features of a model by their names. Where it names none, or the file has no header: all columns but
    /// times, of which there must be `count`.
    Features {
        /// The columns' names.
        names: &'a [String],
        /// How many.
        count: usize,
    },
    /// Columns of a header whose names begin with a prefix, without those of some taxels.
    Prefixed {
        /// What names begin with.
        prefix: &'a str,
        /// Taxels left out: the part of a name before its first underscore.
        without: &'a [String],
    },
}

/// A recording: as many values per row as columns were taken.
#[derive(Clone, Debug, PartialEq)]
pub struct Rows {
    /// Where each column stands in the file, and what its header calls it; empty without a header.
    taken: Vec<(usize, String)>,
    values: Vec<f32>,
    lines: Vec<u64>,
}

/// The files of a folder that have this ending, each after its name without it, in the order of their paths.
///
/// # Errors
/// A folder that cannot be read.
pub fn files(folder: &Path, ending: &str) -> io::Result<Vec<(String, PathBuf)>> {
    let mut paths: Vec<PathBuf> = std::fs::read_dir(folder)?
        .filter_map(|entry| Some(entry.ok()?.path()))
        .filter(|path| path.extension().is_some_and(|e| e == ending))
        .collect();
    paths.sort();
    let named = |path: PathBuf| {
        let stem = path.file_stem().unwrap_or_default().to_string_lossy();
        (stem.into_owned(), path)
    };
    Ok(paths.into_iter().map(named).collect())
}

/// Columns that say when, not what.
const TIMES: [&str; 3] = ["time_us", "timestamp", "time"];

impl Rows {
    /// Reads a file.
    ///
    /// # Errors
    /// A file that cannot be read, a column that is missing, a value that is no finite number: with line and column.
    pub fn read(path: &Path, take: Take<'_>) -> Result<Self, FileError> {
        let label = path.display().to_string();
        let file = std::fs::File::open(path)
            .map_err(|e| FileError::whole(&label, "a readable file", e.to_string()))?;
        Self::parse(&label, file, take)
    }

    fn parse(label: &str, input: impl Read, take: Take<'_>) -> Result<Self, FileError> {
        let mut reader = ReaderBuilder::new()
            .has_headers(false)
            .flexible(true)
            .trim(Trim::All)
            .from_reader(input);
        let mut record = StringRecord::new();
        let mut rows = Self {
            taken: Vec::new(),
            values: Vec::new(),
            lines: Vec::new(),
        };
        let mut first = true;
        while reader
            .read_record(&mut record)
            .map_err(|e| FileError::whole(label, "readable CSV", e.to_string()))?
        {
            let line = record.position().map_or(1, Position::line);
            let wrong = |column: Option<usize>, expected: String, found: &str| FileError {
                line: usize::try_from(line).ok(),
                key: column.map(|c| format!("column {}", c + 1)),
                ..FileError::whole(label, expected, found)
            };
            if std::mem::take(&mut first) {
                let header = record.iter().any(|field| field.parse::<f32>().is_err());
                rows.taken = take
                    .of(&record, header)
                    .map_err(|(expected, found)| wrong(None, expected, &found))?;
                if header {
                    continue;
                }
            }
            for &(column, _) in &rows.taken {
                let field = record.get(column).unwrap_or("nothing");
                match field.parse::<f32>() {
                    Ok(value) if value.is_finite() => rows.values.push(value),
                    _ => return Err(wrong(Some(column), "a finite number".into(), field)),
                }
            }
            rows.lines.push(line);
        }
        if rows.lines.is_empty() {
            return Err(FileError::whole(label, "at least one row", "none"));
        }
        Ok(rows)
    }

    /// How many.
    pub fn count(&self) -> usize {
        self.lines.len()
    }

    /// The rows, first to last.
    pub fn iter(&self) -> impl Iterator<Item = &[f32]> {
        self.values.chunks_exact(self.taken.len())
    }

    /// The line of the file that row `index` stands in; 0 beyond the last.
    pub fn line(&self, index: usize) -> u64 {
        self.lines.get(index).copied().unwrap_or(0)
    }

    /// The names of the columns taken, and all values, row after row.
    pub fn into_parts(self) -> (Vec<String>, Vec<f32>) {
        let names = self.taken.into_iter().map(|(_, name)| name);
        (names.collect(), self.values)
    }
}

impl Take<'_> {
    /// The columns to take by the first line; or what was expected and what was found.
    fn of(
        self,
        first: &StringRecord,
        header: bool,
    ) -> Result<Vec<(usize, String)>, (String, String)> {
        let called = |column: usize| {
            let name = first.get(column).filter(|_| header);
            (column, name.unwrap_or_default().to_owned())
        };
        let (names, count) = match self {
            Self::Features { names, count } => (names, count),
            Self::Prefixed { prefix, without } => {
                let wanted = |field: &str| {
                    let taxel = field.split('_').next();
                    field.starts_with(prefix) && !without.iter().any(|t| taxel == Some(t))
                };
                let taken = (0..first.len()).filter(|&c| header && wanted(&first[c]));
                let taken: Vec<_> = taken.map(called).collect();
                let missing = || (format!("columns {prefix}*"), "none of that name".into());
                return (!taken.is_empty()).then_some(taken).ok_or_else(missing);
            }
        };
        let place = |name: &String| first.iter().position(|field| field == name);
        if header && names.iter().any(|name| place(name).is_some()) {
            let missing = |name| (format!("a column {name}"), "none of that name".into());
            let named = |name| place(name).map(called).ok_or_else(|| missing(name));
            return names.iter().map(named).collect();
        }
        let time = |column: usize| header && TIMES.contains(&&first[column]);
        let taken: Vec<_> = (0..first.len()).filter(|&c| !time(c)).map(called).collect();
        if taken.len() == count {
            return Ok(taken);
        }
        let expected = match names {
            [] => format!("{count} columns beside times"),
            [name, ..] => format!("the model's columns ({name}, ..), or {count} beside times"),
        };
        Err((expected, taken.len().to_string()))
    }
}

#[cfg(test)]
#[path = "rows_tests.rs"]
mod tests;
