//! The rate of a recording that has no times of its own.

use std::io::{BufRead, Read};
use std::path::{Path, PathBuf};

use crate::cli::rate as parse_rate;
use palpate_files::{FileError, is_stream, open, read_text};
use palpate_run::Failure;

/// File beside the recordings of a trial that says how often their rows came.
const META: &str = "meta_data.csv";
const KEY: &str = "frequency_hz";
/// Most bytes of such a file.
const MOST_META: u64 = 1 << 16;

/// A rate, and the file it stands in where it was not typed.
#[derive(Debug, Default, PartialEq)]
pub struct Rate {
    /// Rows a second; none where the recording has times, or nothing says.
    pub hz: Option<f64>,
    /// The file that gives the rate; `None` where the rate was typed.
    pub found_in: Option<PathBuf>,
}

/// The rate as typed, else as `meta_data.csv` beside the recordings gives it.
///
/// # Errors
/// A `meta_data.csv` that gives no rate (file, line, key), or two that disagree.
pub fn rate_of(typed: Option<f64>, recordings: &[PathBuf]) -> Result<Rate, Failure> {
    let mut rate = Rate {
        hz: typed,
        found_in: None,
    };
    if typed.is_some() {
        return Ok(rate);
    }
    for recording in recordings {
        let meta = recording.with_file_name(META);
        if *recording == meta || !meta.is_file() || !lacks_times(recording) {
            continue;
        }
        let hz = read(&meta)?;
        match (rate.hz, &rate.found_in) {
            (Some(other), Some(first)) if (other - hz).abs() > 0.0 => {
                return Err(Failure::Input(format!(
                    "{}: {KEY}: expected {other} as in {}, found {hz} (or give --rate HZ)",
                    meta.display(),
                    first.display()
                )));
            }
            _ => (rate.hz, rate.found_in) = (Some(hz), Some(meta)),
        }
    }
    Ok(rate)
}

/// Tells whether a recording can be opened and its header has no `time_us`.
fn lacks_times(recording: &Path) -> bool {
    if is_stream(recording) {
        return false; // it can be read once
    }
    let Ok(file) = open(recording, "a recording") else {
        return false; // reading it will say why
    };
    let mut start = Vec::new();
    let read = std::io::BufReader::new(file.take(64)).read_until(b',', &mut start);
    read.is_ok() && !String::from_utf8_lossy(&start).contains("time_us")
}

fn read(meta: &Path) -> Result<f64, Failure> {
    let path = meta.display().to_string();
    let bad = |line, expected: &str, found: String| FileError {
        path: path.clone(),
        line: Some(line),
        key: Some(KEY.into()),
        expected: format!("{expected} (or give --rate HZ)"),
        found,
    };
    let text = read_text(meta, "a readable file", MOST_META)?;
    let mut lines = text.lines().map(|line| line.split(',').map(str::trim));
    let column = lines
        .next()
        .and_then(|mut names| names.position(|n| n == KEY));
    let column = column.ok_or_else(|| bad(1, "such a column", "none".into()))?;
    let value = lines.next().and_then(|mut row| row.nth(column));
    let value = value.ok_or_else(|| bad(2, "a rate", "nothing".into()))?;
    Ok(parse_rate(value).map_err(|_| bad(2, "a rate above 0 Hz", format!("`{value}`")))?)
}
