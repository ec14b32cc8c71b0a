//! Arrays of NumPy as recorded taxels: single-precision numbers, a row per frame, or slides as the iCub's set of
//! textures has them.

use std::path::Path;
use std::sync::Arc;

use palpate_files::{Columns, FileError, read_bytes};
use palpate_run::{RowSource, TaxelTable};

use super::Reading;

/// The most bytes that are read: the set's blobs have 4 MB.
const MOST: u64 = 256 << 20;
/// Bytes before the header: magic, version, the header's length.
const BEFORE: usize = 10;
/// Rows, columns and steps of a slide of the iCub's set, by its header. In memory a slide is columns x steps x rows:
/// only so do readings run on smoothly from step to step.
const SLIDE: [usize; 3] = [6, 10, 75];

/// Reads an array: the rows, and remarks on them.
///
/// # Errors
/// A file that is no such array, no rate, a number that is no count.
pub(super) fn read_npy(
    path: &Path,
    columns: &Columns,
    reading: &Reading,
) -> Result<(Arc<dyn RowSource>, Vec<String>), FileError> {
    let label = path.display().to_string();
    let bad = |expected: &str, found: String| FileError::whole(&label, expected, found);
    let bytes = read_bytes(path, "a NumPy array", MOST)?;
    let (header, data) = split(&bytes).ok_or_else(|| {
        let expected = "an array of version 1 whose header is whole";
        bad(expected, "another, or a part of one".into())
    })?;
    if !header.contains("'<f4'") || header.contains("'fortran_order': True") {
        let expected = "little-endian single-precision numbers ('<f4') in C order";
        return Err(bad(expected, header.trim().to_owned()));
    }
    let values: Vec<f32> = data
        .chunks_exact(4)
        .map(|b| f32::from_le_bytes([b[0], b[1], b[2], b[3]]))
        .collect();
    let shape = shape(header);
    let [rows, wide, steps] = SLIDE;
    let whole = shape.iter().product::<usize>() == values.len() && data.len().is_multiple_of(4);
    let frames = match shape[..] {
        [frames, width] if whole && width == columns.count() => frames,
        [slides, r, c, s] if whole && [r, c, s] == SLIDE && columns.count() == r * c => slides * s,
        _ => {
            let expected = format!(
                "frames x {} ({} taxels of {} axes in layout `{}`), or the iCub's slides x 6 x 10 x 75 for 60 taxels",
                columns.count(),
                columns.taxels,
                columns.axes,
                columns.layout
            );
            return Err(bad(
                &expected,
                format!("{shape:?}, {} numbers", values.len()),
            ));
        }
    };
    let rate_hz = reading
        .timing
        .rate_hz
        .ok_or_else(|| bad("a rate (--rate HZ): an array says none", "none".into()))?;
    let place = |frame: usize, column: usize| match shape.len() {
        2 => frame * columns.count() + column,
        _ => {
            let (slide, step) = (frame / steps, frame % steps);
            let (row, across) = (column / wide, column % wide);
            slide * rows * wide * steps + (across * steps + step) * rows + row
        }
    };
    let rest = reading.rest_rows;
    let mut counts = vec![0; rest * columns.count()];
    for (frame, column) in (0..frames).flat_map(|f| (0..columns.count()).map(move |c| (f, c))) {
        let value = values[place(frame, column)];
        if !(0.0..=65_535.0).contains(&value) {
            return Err(bad(
                "numbers from 0 to 65535",
                format!("{value} in frame {frame}, column {column}"),
            ));
        }
        counts.push(value.round() as u16);
    }
    let table = TaxelTable {
        time_us: (0..rest + frames)
            .map(|n| (n as f64 * 1e6 / rate_hz).round() as u64)
            .collect(),
        counts,
        columns: columns.count(),
    };
    let note = format!(
        "{label}: an array's readings are compensated; {rest} rows at rest were put before them"
    );
    let notes = Vec::from_iter((rest > 0).then_some(note));
    Ok((Arc::new(table), notes))
}

/// Header and data of an array.
fn split(bytes: &[u8]) -> Option<(&str, &[u8])> {
    let [low, high] = *bytes.get(8..BEFORE)?.as_array()?;
    let (header, data) =
        bytes[BEFORE..].split_at_checked(usize::from(u16::from_le_bytes([low, high])))?;
    let first = bytes.get(6) == Some(&1);
    Some((std::str::from_utf8(header).ok().filter(|_| first)?, data))
}

/// The numbers between the parentheses of `shape`.
fn shape(header: &str) -> Vec<usize> {
    let inside = header
        .split_once("'shape': (")
        .and_then(|(_, rest)| rest.split_once(')'));
    let numbers = inside.map_or("", |(inside, _)| inside).split(',');
    numbers.filter_map(|n| n.trim().parse().ok()).collect()
}
