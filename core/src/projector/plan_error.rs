//! What a loop cannot be built of.

use core::fmt;

use super::TextureError;
use crate::contact::SettingsError;
use crate::guard::PlantError;
use crate::illusion::{CalibrationError, IllusionError, MapError, TimingError};
use crate::skin::BaselineError;

/// Why a plan is no loop.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum PlanError {
    /// The module that shall drive the display does not exist; how many there are.
    NoSuchModule(usize),
    /// The baseline's settings.
    Baseline(BaselineError),
    /// The compression settings.
    Compression(SettingsError),
    /// A calibration that is not of this display's wires.
    Calibration(CalibrationError),
    /// A texture that does not fit the skin.
    Texture(TextureError),
    /// A part of the skin that cannot be laid over the display.
    Map(MapError),
    /// A law that cannot be laid over the display.
    Illusion(IllusionError),
    /// A stimulus that cannot be.
    Timing(TimingError),
    /// Hardware that the guard cannot protect.
    Plant(PlantError),
}

impl fmt::Display for PlanError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NoSuchModule(n) => write!(f, "expected a driving module below {n}"),
            Self::Baseline(e) => e.fmt(f),
            Self::Compression(e) => e.fmt(f),
            Self::Calibration(e) => write!(f, "expected {e}"),
            Self::Texture(e) => e.fmt(f),
            Self::Map(e) => e.fmt(f),
            Self::Illusion(e) => write!(f, "expected {e}"),
            Self::Timing(e) => write!(f, "expected {e}"),
            Self::Plant(e) => e.fmt(f),
        }
    }
}

impl core::error::Error for PlanError {}

impl From<MapError> for PlanError {
    fn from(e: MapError) -> Self {
        Self::Map(e)
    }
}

impl From<IllusionError> for PlanError {
    fn from(e: IllusionError) -> Self {
        Self::Illusion(e)
    }
}

impl From<TimingError> for PlanError {
    fn from(e: TimingError) -> Self {
        Self::Timing(e)
    }
}

impl From<PlantError> for PlanError {
    fn from(e: PlantError) -> Self {
        Self::Plant(e)
    }
}

impl From<SettingsError> for PlanError {
    fn from(e: SettingsError) -> Self {
        Self::Compression(e)
    }
}

impl From<TextureError> for PlanError {
    fn from(e: TextureError) -> Self {
        Self::Texture(e)
    }
}

impl From<BaselineError> for PlanError {
    fn from(e: BaselineError) -> Self {
        Self::Baseline(e)
    }
}
