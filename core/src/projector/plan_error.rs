//! Errors of a plan from which no loop can be built.

use super::TextureError;
use crate::contact::SettingsError;
use crate::guard::PlantError;
use crate::illusion::{CalibrationError, IllusionError, MapError};
use crate::render::PatternError;
use crate::skin::BaselineError;

/// Error of a plan from which no loop can be built.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum PlanError {
    /// A driving module that does not exist, with the number of modules.
    #[error("expected a driving module below {0}")]
    NoSuchModule(usize),
    /// Settings of the baseline that are refused.
    #[error(transparent)]
    Baseline(#[from] BaselineError),
    /// Settings of the compression that are refused.
    #[error(transparent)]
    Compression(#[from] SettingsError),
    /// A calibration that is not of this display's wires.
    #[error("expected {0}")]
    Calibration(CalibrationError),
    /// A texture that does not fit the skin.
    #[error(transparent)]
    Texture(#[from] TextureError),
    /// A part of the skin that cannot be laid over the display.
    #[error(transparent)]
    Map(#[from] MapError),
    /// A law that cannot be laid over the display.
    #[error("expected {0}")]
    Illusion(#[from] IllusionError),
    /// Pulses so far apart that no burst of them fits between onsets.
    #[error("expected {0}")]
    Pattern(#[from] PatternError),
    /// Hardware that the guard cannot protect.
    #[error(transparent)]
    Plant(#[from] PlantError),
}
