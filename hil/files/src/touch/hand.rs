//! Samples of one finger of a hand: a touch that was made on a page and can be repeated to the bit.

use super::{Touch, TouchPoint};
use crate::error::FileError;
use crate::source::Source;

/// Sample of a hand: time (us), place (um, right and up of the module's centre), force (mN; 0: lifted), width (um).
pub type HandSample = [i64; 5];

/// Samples of one finger at most: an hour at 60 per second.
pub const MOST_SAMPLES: usize = 216_000;

/// The name, key, range and unit of each column.
const COLUMNS: [(&str, i64, i64); 5] = [
    ("t_us", 0, 86_400_000_000),
    ("x_um", -1_000_000, 1_000_000),
    ("y_um", -1_000_000, 1_000_000),
    ("force_mn", 0, 20_000),
    ("diameter_um", 500, 500_000),
];

/// The finger at `t_s`, by the last sample that is not later. None while it is lifted.
pub(super) fn at(samples: &[HandSample], t_s: f64) -> Option<TouchPoint> {
    // A nanosecond is more than the error of a day's microseconds in a double.
    let next = samples.partition_point(|sample| sample[0] as f64 <= t_s * 1e6 + 1e-4);
    let &[_, x, y, force, diameter] = samples.get(next.checked_sub(1)?)?;
    (force > 0).then_some(TouchPoint {
        x_mm: x as f64 * 1e-3,
        y_mm: y as f64 * 1e-3,
        force_n: force as f64 * 1e-3,
        diameter_mm: diameter as f64 * 1e-3,
    })
}

/// Checks that numbers make a sample. The error has the first one that does not, its name and its range.
///
/// # Errors
/// The column, and the expectation there.
pub fn check_sample(sample: &HandSample) -> Result<(), (usize, String)> {
    for (column, (value, (name, low, high))) in sample.iter().zip(COLUMNS).enumerate() {
        if !(low..=high).contains(value) {
            return Err((column, format!("{name}: a number from {low} to {high}")));
        }
    }
    Ok(())
}

/// Checks a touch by hand that stands under `key`.
pub(super) fn check(
    touch: &Touch,
    source: &Source,
    key: &str,
    length_s: f64,
) -> Result<(), FileError> {
    for name in [
        "force_n",
        "ramp_s",
        "diameter_mm",
        "path.period_s",
        "path.points_mm",
        "path.centre_mm",
        "path.radius_mm",
    ] {
        let key = format!("{key}.{name}");
        if source.states(&key) {
            return Err(source.bad(&key, "nothing: the samples of a hand say it"));
        }
    }
    let samples = &touch.path.samples;
    let at = |rest: &str| format!("{key}.path.samples{rest}");
    if samples.is_empty() || samples.len() > MOST_SAMPLES {
        let expected =
            format!("1 to {MOST_SAMPLES} samples [t_us, x_um, y_um, force_mn, diameter_um]");
        let found = format!("{} samples", samples.len());
        return Err(source.bad_found(&at(""), expected, found));
    }
    let mut newest = None;
    for (index, sample) in samples.iter().enumerate() {
        if let Err((column, expected)) = check_sample(sample) {
            let place = at(&format!("[{index}][{column}]"));
            return Err(source.bad_found(&place, expected, sample[column].to_string()));
        }
        let from_us = newest.map_or(0, |t: i64| t + 1);
        if sample[0] < from_us || sample[0] as f64 > length_s * 1e6 + 0.5 {
            let expected = format!("t_us: a time from {from_us} us to the end of the scene");
            let place = at(&format!("[{index}][0]"));
            return Err(source.bad_found(&place, expected, sample[0].to_string()));
        }
        newest = Some(sample[0]);
    }
    Ok(())
}
