//! Arrays of numbers in binary files, read as the text of a table: a row per frame.
//!
//! NumPy's `.npy` and `.npz` and MATLAB's version 5, of every type and order.

mod matlab;
mod numpy;

use std::path::Path;

use super::error::FileError;
use super::format::Format;
use super::made::Lines;
use super::order::is_computed;
use super::reading::{MOST_VALUES, format_of, read_bytes};

/// Most bytes of a file: the iCub's blobs have 4 MB.
const MOST: u64 = 256 << 20;
/// Rows, columns and steps of a slide of the iCub's set, as its header states them. In memory a slide is columns x
/// steps x rows: only in that order do readings run on smoothly from step to step.
const SLIDE: [usize; 3] = [6, 10, 75];
/// Least span of averaged counts, which are not whole; values closer together are in another unit.
const LEAST_SPAN: f32 = 16.0;

/// An array as a file holds it.
#[derive(Debug)]
struct Stored {
    /// Name of the array; empty in a file of one array.
    name: String,
    shape: Vec<usize>,
    /// True if the first index runs fastest.
    is_fortran: bool,
    values: Vec<f64>,
}

/// Places of the values of a frame.
#[derive(Debug)]
struct View {
    frames: usize,
    /// Offsets of the columns from the frame's own.
    columns: Vec<usize>,
    /// Number of frames that are `step` apart. The next ones begin `jump` after the first of these.
    run: usize,
    step: usize,
    jump: usize,
    /// Assumptions made about the array.
    note: Option<String>,
}

/// Reads an array as the text of a table.
#[derive(Debug)]
pub(super) struct Array {
    label: String,
    name: String,
    view: View,
    values: Vec<f32>,
    times: Option<Vec<f64>>,
    /// Rows at rest before the first.
    rest: usize,
    rounds: bool,
    /// Rows so far, with the heading and those at rest.
    row: usize,
}

/// Reads the array of a file that has `count` columns, or any number of columns if `count` is 0. Up to `rest_rows`
/// rows at rest are put before readings that are compensated.
///
/// # Errors
/// A file that is no such file, or holds no such array, or several.
pub(super) fn read(path: &Path, count: usize, rest_rows: usize) -> Result<Array, FileError> {
    let label = path.display().to_string();
    let bytes = read_bytes(path, "an array", MOST)?;
    let stored = match format_of(path) {
        Some(Format::Npz) => numpy::archive(&bytes),
        Some(Format::Matlab) => matlab::arrays(&bytes),
        _ => numpy::array(&bytes).map(|array| vec![array]),
    };
    let stored = stored.map_err(|(expected, found)| FileError::whole(&label, expected, found))?;
    chosen(label, stored, count, rest_rows)
}

fn chosen(
    label: String,
    mut stored: Vec<Stored>,
    count: usize,
    rest_rows: usize,
) -> Result<Array, FileError> {
    let shapes = || -> Vec<String> {
        let shape = |s: &Stored| {
            let text = format!("{} {:?}, {} numbers", s.name, s.shape, s.values.len());
            text.trim().to_owned()
        };
        stored.iter().map(shape).collect()
    };
    let mut fit: Vec<usize> = Vec::new();
    fit.extend((0..stored.len()).filter(|&n| view(&stored[n], count).is_some()));
    if fit.len() > 1 {
        fit.retain(|&n| !is_computed(&stored[n].name));
    }
    let (&[place], found) = (fit.as_slice(), shapes().join(", ")) else {
        let several = if fit.len() > 1 {
            "one array"
        } else {
            "an array"
        };
        let expected = format!(
            "{several} of frames x {count} (or x taxels x axes, or the iCub's slides x 6 x 10 x 75)"
        );
        return Err(FileError::whole(label, expected, shapes().join(", ")));
    };
    let array = stored.swap_remove(place);
    let Some(view) = view(&array, count) else {
        return Err(FileError::whole(label, "an array of frames", found));
    };
    let is_time = |s: &&Stored| {
        let name = s.name.to_lowercase();
        let named = matches!(
            name.as_str(),
            "t" | "time" | "times" | "timestamp" | "timestamps"
        );
        named && s.values.len() == view.frames
    };
    let times = stored.iter().find(is_time).map(|s| s.values.clone());
    let values: Vec<f32> = array.values.iter().map(|v| *v as f32).collect();
    let is_whole = array.values.iter().all(|v| v.fract().abs() <= 0.0);
    let least = values.iter().copied().fold(f32::MAX, f32::min);
    let span = values.iter().copied().fold(f32::MIN, f32::max) - least;
    let mut array = Array {
        label,
        name: array
            .name
            .chars()
            .map(|c| if c.is_alphanumeric() { c } else { '_' })
            .collect(),
        view,
        values,
        times,
        rest: 0,
        rounds: count > 0 && !is_whole && span >= LEAST_SPAN,
        row: 0,
    };
    // A recording with times of its own begins when they do.
    if array.times.is_none() && array.is_compensated() {
        array.rest = rest_rows;
    }
    Ok(array)
}

/// Finds the frames of `count` columns in an array, or of up to two more: a number and a time before them.
fn view(stored: &Stored, count: usize) -> Option<View> {
    let Stored { shape, .. } = stored;
    // With a 0 the product of some sizes tells nothing of the others.
    if shape.contains(&0)
        || shape
            .iter()
            .try_fold(1_usize, |all, n| all.checked_mul(*n))?
            != stored.values.len()
    {
        return None;
    }
    let [rows, wide, steps] = SLIDE;
    if let [slides, r, c, s] = shape[..]
        && [r, c, s] == SLIDE
        && count == rows * wide
    {
        return Some(View {
            frames: slides * steps,
            columns: (0..count)
                .map(|n| (n % wide) * steps * rows + n / wide)
                .collect(),
            run: steps,
            step: rows,
            jump: rows * wide * steps,
            note: None,
        });
    }
    let strides: Vec<usize> = (0..shape.len())
        .map(|n| match stored.is_fortran {
            true => shape[..n].iter().product(),
            false => shape[n + 1..].iter().product(),
        })
        .collect();
    let (&frames, inner) = shape.split_first()?;
    let fits = |width: usize| count == 0 || (count..=count + 2).contains(&width);
    let width: usize = inner.iter().product();
    let mut note = None;
    let (frames, stride, columns) = if !inner.is_empty() && fits(width) {
        // Readings that the file has axis after axis become taxel by taxel.
        let dims: Vec<usize> = match inner {
            [3, taxels] if *taxels != 3 => {
                note = Some("axes before taxels: the second index is taken for x, y, z".to_owned());
                vec![2, 1]
            }
            _ => (1..shape.len()).collect(),
        };
        (frames, strides[0], offsets(shape, &strides, &dims))
    } else if let [columns, frames] = shape[..]
        && fits(columns)
    {
        note = Some(format!(
            "columns before frames: each of {frames} columns is a frame"
        ));
        (frames, strides[1], offsets(shape, &strides, &[0]))
    } else {
        return None;
    };
    Some(View {
        frames,
        columns,
        run: 1,
        step: 0,
        jump: stride,
        note,
    })
}

/// Offsets of all places of these dimensions, the last one running fastest.
fn offsets(shape: &[usize], strides: &[usize], dims: &[usize]) -> Vec<usize> {
    let mut all = vec![0];
    for &dim in dims {
        let of = |base: usize| (0..shape[dim]).map(move |n| base + n * strides[dim]);
        all = all.into_iter().flat_map(of).collect();
    }
    all
}

impl Array {
    /// Returns true if 0 stands for no pressure: half of the columns and more rest at it.
    fn is_compensated(&self) -> bool {
        let least = |column: usize| {
            let frames = 0..self.view.frames;
            frames
                .map(|f| self.value(f, column))
                .fold(f32::MAX, f32::min)
        };
        let columns = self.view.columns.len();
        let at_zero = (0..columns).filter(|&c| least(c).abs() <= 0.0).count();
        at_zero * 2 >= columns
    }

    fn value(&self, frame: usize, column: usize) -> f32 {
        let View {
            run, step, jump, ..
        } = self.view;
        let place = frame / run * jump + frame % run * step + self.view.columns[column];
        self.values.get(place).copied().unwrap_or_default()
    }

    /// Remarks on the readings.
    pub(super) fn note(&self) -> Option<String> {
        let mut parts = Vec::from_iter(self.view.note.clone());
        if self.rest > 0 {
            parts.push(format!(
                "an array's readings are compensated; {} rows at rest were put before them",
                self.rest
            ));
        }
        (!parts.is_empty()).then(|| format!("{}: {}", self.label, parts.join("; ")))
    }
}

/// An array beside times has a heading.
impl Lines for Array {
    fn add(&mut self, text: &mut Vec<u8>) -> Result<bool, FileError> {
        let columns = self.view.columns.len();
        let heading = usize::from(self.times.is_some());
        let row = self.row;
        self.row += 1;
        if row < heading {
            text.extend(b"time");
            for column in 0..columns {
                text.extend(format!(",{}_{column}", self.name).bytes());
            }
            text.push(b'\n');
            return Ok(true);
        }
        let Some(frame) = (row - heading).checked_sub(self.rest) else {
            text.extend(vec!["0"; columns].join(",").bytes());
            text.push(b'\n');
            return Ok(true);
        };
        if frame >= self.view.frames {
            return Ok(false);
        }
        let time = self.times.as_ref().and_then(|times| times.get(frame));
        text.extend(time.map(f64::to_string).unwrap_or_default().bytes());
        for column in 0..columns {
            if column > 0 || time.is_some() {
                text.push(b',');
            }
            let value = self.value(frame, column);
            let value = if self.rounds { value.round() } else { value };
            text.extend(value.to_string().bytes());
        }
        text.push(b'\n');
        Ok(true)
    }
}

/// The type of a number in a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    Signed(usize),
    Unsigned(usize),
    Float(usize),
}

impl Kind {
    const fn width(self) -> usize {
        match self {
            Self::Signed(width) | Self::Unsigned(width) | Self::Float(width) => width,
        }
    }

    /// Numbers of this type; none where the type is unknown, or where they are more than a table may hold.
    fn numbers(self, bytes: &[u8], is_big: bool) -> Option<Vec<f64>> {
        let width = self.width();
        let is_known = matches!(width, 1 | 2 | 4 | 8) && self != Self::Float(1);
        if !is_known || bytes.len() / width > MOST_VALUES {
            return None;
        }
        let number = |chunk: &[u8]| {
            let mut bits = 0_u64;
            let mut add = |byte: &u8| bits = bits << 8 | u64::from(*byte);
            match is_big {
                true => chunk.iter().for_each(&mut add),
                false => chunk.iter().rev().for_each(&mut add),
            }
            match self {
                Self::Unsigned(_) => bits as f64,
                Self::Signed(width) => {
                    let unused = 64 - 8 * width;
                    ((bits << unused).cast_signed() >> unused) as f64
                }
                Self::Float(2) => half(bits),
                Self::Float(4) => f64::from(f32::from_bits(bits as u32)),
                Self::Float(_) => f64::from_bits(bits),
            }
        };
        Some(bytes.chunks_exact(width).map(number).collect())
    }
}

/// A number of half precision (IEEE 754).
fn half(bits: u64) -> f64 {
    let sign = if bits & 0x8000 == 0 { 1.0 } else { -1.0 };
    let (exponent, fraction) = (bits >> 10 & 0x1f, (bits & 0x3ff) as f64 / 1024.0);
    sign * match exponent {
        0 => fraction * libm::exp2(-14.0),
        0x1f if fraction > 0.0 => f64::NAN,
        0x1f => f64::INFINITY,
        e => (1.0 + fraction) * libm::exp2(e as f64 - 15.0),
    }
}

/// Expectation of a file, and the finding in its place.
type Unread = (&'static str, String);

/// A little-endian number of up to eight bytes in a file.
fn word(bytes: &[u8], at: usize, width: usize) -> Option<usize> {
    let field = bytes.get(at..at.checked_add(width)?)?;
    let number = field
        .iter()
        .rev()
        .fold(0_u64, |n, byte| n << 8 | u64::from(*byte));
    usize::try_from(number).ok()
}

/// Unpacks parts of a file, all of them of at most as many bytes as a file may have.
struct Unpacking {
    left: usize,
}

impl Unpacking {
    const fn new() -> Self {
        Self {
            left: MOST as usize,
        }
    }

    fn kept(&mut self, part: Vec<u8>) -> Option<Vec<u8>> {
        self.left = self.left.checked_sub(part.len())?;
        Some(part)
    }

    /// Unpacks a part of an archive.
    fn deflated(&mut self, packed: &[u8]) -> Option<Vec<u8>> {
        let part = miniz_oxide::inflate::decompress_to_vec_with_limit(packed, self.left);
        self.kept(part.ok()?)
    }

    /// Unpacks a part with zlib's own head.
    fn zlib(&mut self, packed: &[u8]) -> Option<Vec<u8>> {
        let part = miniz_oxide::inflate::decompress_to_vec_zlib_with_limit(packed, self.left);
        self.kept(part.ok()?)
    }
}

#[cfg(test)]
mod tests;
