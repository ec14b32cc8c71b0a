//! Recorded taxels: CSV of raw counts, one row a frame.

use std::path::Path;

use palpate_files::{FileError, SensorLayout};
use palpate_run::TaxelTable;

/// What a recording must hold: `taxels` times `axes` columns, `txl1_x,txl1_y,txl1_z,...` (`_z` alone for one axis).
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Columns {
    /// Taxels a frame.
    pub taxels: usize,
    /// 1 or 3.
    pub axes: u8,
    /// The layout that asks for them, for messages.
    pub layout: String,
}

impl Columns {
    /// One module's readings.
    #[must_use]
    pub fn of_module(layout: &SensorLayout, module: usize) -> Option<Self> {
        Some(Self {
            taxels: layout.modules.get(module)?.readings(),
            axes: layout.axes,
            layout: layout.name.clone(),
        })
    }

    /// The whole skin's readings, module after module.
    #[must_use]
    pub fn of_skin(layout: &SensorLayout) -> Self {
        Self {
            taxels: layout.readings(),
            axes: layout.axes,
            layout: layout.name.clone(),
        }
    }

    fn count(&self) -> usize {
        self.taxels * usize::from(self.axes)
    }

    /// The name of a column, counted without the time.
    pub(super) fn name(&self, index: usize) -> String {
        let axes = usize::from(self.axes);
        let axis = if axes == 1 {
            "z"
        } else {
            ["x", "y", "z"][index % 3]
        };
        format!("txl{}_{axis}", index / axes + 1)
    }
}

/// Reads a recording. A first column `time_us` gives the times; without it `rate_hz` must.
///
/// # Errors
/// An unreadable or empty file, wrong columns, or the first value that is not a whole count from 0 to 65535,
/// with its line and column.
pub fn read_taxel_csv(
    path: &Path,
    columns: &Columns,
    rate_hz: Option<f64>,
) -> Result<TaxelTable, FileError> {
    let label = path.display().to_string();
    let file = std::fs::File::open(path)
        .map_err(|error| FileError::whole(&label, "a readable file", error.to_string()))?;
    parse(&label, file, columns, rate_hz)
}

/// The same from any reader; `label` names it in errors.
pub(super) fn parse(
    label: &str,
    input: impl std::io::Read,
    columns: &Columns,
    rate_hz: Option<f64>,
) -> Result<TaxelTable, FileError> {
    let wrong = |line: u64, key: Option<String>, expected: String, found: String| FileError {
        path: label.into(),
        line: usize::try_from(line).ok(),
        key,
        expected,
        found,
    };
    let mut reader = csv::ReaderBuilder::new()
        .has_headers(false)
        .flexible(true)
        .trim(csv::Trim::All)
        .from_reader(input);
    let mut record = csv::ByteRecord::new();
    let mut next = |record: &mut csv::ByteRecord| -> Result<Option<u64>, FileError> {
        let more = reader
            .read_byte_record(record)
            .map_err(|error| FileError::whole(label, "readable CSV", error.to_string()))?;
        Ok(more.then(|| record.position().map_or(1, csv::Position::line)))
    };

    let Some(line) = next(&mut record)? else {
        return Err(FileError::whole(
            label,
            "a header and rows",
            "an empty file",
        ));
    };
    let timed = header(&record, columns)
        .map_err(|(key, expected, found)| wrong(line, key, expected, found))?;
    let offset = usize::from(timed);
    let rate = match rate_hz {
        _ if timed => None,
        Some(rate) if rate.is_finite() && rate > 0.0 => Some(rate),
        Some(rate) => {
            let expected = "a rate above 0 Hz";
            return Err(FileError::whole(label, expected, format!("{rate}")));
        }
        None => {
            let found = "neither".to_owned();
            return Err(wrong(
                line,
                None,
                "a first column time_us, or a rate (--rate HZ)".into(),
                found,
            ));
        }
    };

    let mut table = TaxelTable {
        time_us: Vec::new(),
        counts: Vec::new(),
        columns: columns.count(),
    };
    while let Some(line) = next(&mut record)? {
        let width = columns.count() + offset;
        if record.len() != width {
            let found = format!("{}", record.len());
            return Err(wrong(
                line,
                None,
                format!("{width} columns as in the header"),
                found,
            ));
        }
        let time = match rate {
            None => time(&record[0], &table.time_us).map_err(|expected| {
                wrong(
                    line,
                    Some("column 1 (time_us)".into()),
                    expected,
                    text(&record[0]),
                )
            })?,
            // Frame numbers are far below 2^53, so the product is exact enough to round.
            Some(rate) => libm::round(table.time_us.len() as f64 * 1e6 / rate) as u64,
        };
        table.time_us.push(time);
        for (index, field) in record.iter().skip(offset).enumerate() {
            let Some(count) = count(field) else {
                let key = format!("column {} ({})", index + offset + 1, columns.name(index));
                let expected = "a whole count from 0 to 65535".into();
                return Err(wrong(line, Some(key), expected, text(field)));
            };
            table.counts.push(count);
        }
    }
    if table.time_us.is_empty() {
        let expected = "at least one row";
        return Err(FileError::whole(label, expected, "a header alone"));
    }
    Ok(table)
}

/// Whether the header has times; or key, expected and found.
fn header(
    record: &csv::ByteRecord,
    columns: &Columns,
) -> Result<bool, (Option<String>, String, String)> {
    let first = record.get(0).unwrap_or_default();
    let first = first.strip_prefix(b"\xEF\xBB\xBF").unwrap_or(first);
    let timed = first == b"time_us";
    let offset = usize::from(timed);
    for index in 0..columns.count().min(record.len() - offset) {
        let field = if index + offset == 0 {
            first
        } else {
            &record[index + offset]
        };
        let name = columns.name(index);
        if field != name.as_bytes() {
            let key = format!("column {}", index + offset + 1);
            return Err((Some(key), format!("the header `{name}`"), text(field)));
        }
    }
    if record.len() - offset != columns.count() {
        let expected = format!(
            "{} taxel columns ({} taxels of {} axes in layout `{}`)",
            columns.count(),
            columns.taxels,
            columns.axes,
            columns.layout
        );
        return Err((None, expected, format!("{}", record.len() - offset)));
    }
    Ok(timed)
}

/// A whole count, also written as `49202.0`.
fn count(field: &[u8]) -> Option<u16> {
    let value: f64 = std::str::from_utf8(field).ok()?.parse().ok()?;
    let whole = (0.0..=65_535.0).contains(&value) && (value - libm::floor(value)).abs() <= 0.0;
    // In range and whole: the cast changes nothing.
    whole.then_some(value as u16)
}

/// Longest recording, as the longest scene: a slip in a time must not make a run of years.
const LONGEST_US: u64 = 86_400_000_000;

fn time(field: &[u8], before: &[u64]) -> Result<u64, String> {
    let time = std::str::from_utf8(field)
        .ok()
        .and_then(|text| text.parse().ok())
        .ok_or("a whole number of microseconds")?;
    match (before.first(), before.last()) {
        (_, Some(last)) if time <= *last => Err(format!("more than the row before, {last}")),
        (Some(first), _) if time - first > LONGEST_US => {
            Err(format!("at most a day after the first row, {first}"))
        }
        _ => Ok(time),
    }
}

fn text(field: &[u8]) -> String {
    if field.is_empty() {
        return "nothing".into();
    }
    let text: String = String::from_utf8_lossy(field).chars().take(40).collect();
    format!("`{}`", text.escape_debug())
}
