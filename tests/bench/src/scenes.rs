//! Shipped scenes and layouts: loaded, changed and run.

use palpate_core::illusion::Display;
use palpate_core::skin::Layout;
use palpate_core::units::{Board, Channel};
use palpate_files::{LayoutFile, Scene, Setup, load_bench, load_layout, load_scene};
use palpate_live::host;
use palpate_live::views::Wanted;
use palpate_run::{Failure, Input, Keep, Outcome, plan};

/// A scene on the emulated bench, changed.
///
/// # Errors
/// A scene that does not fit the bench.
pub fn changed(name: &str, change: impl FnOnce(&mut Scene)) -> Result<Setup, Failure> {
    let mut scene = load_scene(name)?;
    change(&mut scene.value);
    Ok(Setup::join(scene, load_bench("emulated")?)?)
}

/// A run with every frame timed.
///
/// # Errors
/// The errors of [`host::run`].
pub fn run(setup: &Setup, input: &Input) -> Result<Outcome, Failure> {
    host::run(setup, input, 1, Keep::default(), Wanted::default())
}

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
