//! Comparison of a logic analyser's capture of the PWM pins with the schedule that was to come out of them.
//!
//! A capture knows neither the run's clock nor the chip's oscillator: both are found from its pulses. The rest is
//! measured: frequency, pulse width, phase, blank periods, missing and stray pulses. Parts of the plan that the capture
//! lacks are counted too: without them there is no good verdict.
#![doc = include_str!("../README.md")]
#![forbid(unsafe_code)]

mod align;
mod compare;
mod coverage;
mod csv;
mod declared;
#[cfg(test)]
mod draws;
mod dump;
mod edges;
mod fst;
mod ghw;
mod leb128;
mod plan;
mod tally;

pub use align::Pins;
pub use compare::{Comparison, Measurement, compare};
pub use coverage::Coverage;
pub use edges::{Capture, Signal};

use std::path::Path;

use palpate_files::{FileError, Format, format_of, open};

/// Most changes of all signals of a capture, 16 bytes each.
const MOST_CHANGES: usize = 4 << 20;

fn too_long(label: &str, line: Option<usize>) -> FileError {
    FileError {
        line,
        ..FileError::whole(
            label,
            format!("at most {MOST_CHANGES} changes"),
            "more (cut the capture, or leave other channels out)",
        )
    }
}

/// Reads a capture: VCD, FST, GHW, or CSV as sigrok or Saleae's Logic write it. A text that is cut short or damaged gives
/// what came before, with a note in [`Capture::notes`].
///
/// # Errors
/// [`FileError`] for a file of another kind, a damaged FST or GHW dump, or a file without a digital signal.
pub fn read(path: &Path) -> Result<Capture, FileError> {
    let label = path.display().to_string();
    let expected = "a capture, VCD, FST, GHW or CSV";
    let named = path.extension().is_some_and(|e| e == "csv");
    let format = match format_of(path) {
        // A CSV of one column, or with remarks, has no mark.
        Some(Format::Toml) | None if named => Format::Csv,
        Some(Format::Toml) | None => Format::Vcd,
        Some(format) => format,
    };
    let file = || open(path, expected);
    let capture = match format {
        Format::Csv => csv::read(&label, file()?)?,
        Format::Vcd => dump::read(&label, file()?)?,
        Format::Fst => fst::read(&label, file()?)?,
        Format::Ghw => ghw::read(&label, file()?)?,
        other => return Err(FileError::whole(label, expected, other.noun())),
    };
    if capture.signals.is_empty() {
        return Err(FileError::whole(&label, "a digital signal", "none"));
    }
    Ok(capture)
}

#[cfg(test)]
mod tests;
