//! Shipped scenes and layouts: loaded, changed and run.

use palpate_core::illusion::Display;
use palpate_core::skin::Layout;
use palpate_core::units::{Board, Channel};
use palpate_files::{LayoutFile, load_layout};
use palpate_run::{Failure, Outcome, plan};

/// Median time of a frame, microseconds.
pub fn frame_us(outcome: &Outcome) -> f64 {
    outcome.summary.frame_us.map_or(f64::NAN, |t| t.median)
}

/// A skin by its name.
///
/// # Errors
/// No such sensor layout.
pub fn skin(name: &str) -> Result<Layout, Failure> {
    match load_layout(name)?.value {
        LayoutFile::Sensor(file) => plan::layout(&file),
        LayoutFile::Display(_) => Err(Failure::Input(format!("{name}: expected a sensor layout"))),
    }
}

/// A shipped display, eight wires per board.
///
/// # Errors
/// No such display layout.
pub fn display(name: &str) -> Result<Display, Failure> {
    match load_layout(name)?.value {
        LayoutFile::Display(file) => plan::display_of(&file, |wire| {
            (Board((wire / 8) as u8), Channel((wire % 8) as u8))
        }),
        LayoutFile::Sensor(_) => Err(Failure::Input(format!("{name}: expected a display"))),
    }
}
