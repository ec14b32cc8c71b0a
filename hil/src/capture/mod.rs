//! What a logic analyser saw of the PWM pins, held against the schedule that was to come out of them.
//!
//! A capture knows neither the run's clock nor the chip's oscillator: both are found from its pulses. What is
//! left is measured: frequency, pulse width, phase, blank periods, missing and stray pulses. What the capture
//! does not hold of the plan is counted too: without it there is no good verdict.

mod align;
mod compare;
mod coverage;
mod csv;
mod edges;
mod plan;
mod tally;
mod verdict;

pub use align::Pins;
pub use compare::{Comparison, Measurement, compare};
pub use coverage::Coverage;
pub use edges::{Capture, Signal};
pub use verdict::{Conclusion, Verdict};

use std::path::Path;

use palpate_files::FileError;

/// Reads a capture: VCD, or CSV as sigrok or Saleae's Logic write it. One that is cut short or damaged gives
/// what came before, with a note in [`Capture::notes`].
///
/// # Errors
/// [`FileError`] for a file of another kind, or one without a digital signal.
pub fn read(path: &Path) -> Result<Capture, FileError> {
    let label = path.display().to_string();
    let bytes = std::fs::read(path)
        .map_err(|e| FileError::whole(&label, "a readable capture", e.to_string()))?;
    let capture = match path.extension().and_then(|e| e.to_str()) {
        Some("csv") => csv::read(&label, &bytes)?,
        _ => edges::read_vcd(&label, &bytes)?,
    };
    if capture.signals.is_empty() {
        return Err(FileError::whole(&label, "a digital signal", "none"));
    }
    Ok(capture)
}

#[cfg(test)]
mod tests;
