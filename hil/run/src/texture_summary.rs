//! Felt textures of a run, for its summary.

use palpate_core::projector::Projector;
use palpate_files::{Setup, TextureModel};
use serde::Serialize;

use crate::failure::Failure;
use crate::recorder::Recorder;

fn is_zero(count: &u64) -> bool {
    *count == 0
}

/// Figures of a felt texture.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct TextureSummary {
    /// Windows that went through the network and were felt.
    pub windows: u32,
    /// Mean roughness, 0 to 1.
    pub roughness: f64,
    /// Pulses that were left out for a wire to rest.
    pub rested_pulses: u64,
    /// Taps of the surface, met or left; left out for none.
    #[serde(skip_serializing_if = "is_zero")]
    pub taps: u64,
    /// Properties of the surface outside the range that the model learned; left out for none.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub extrapolated: Vec<String>,
}

impl TextureSummary {
    /// Summary of the windows that a recorder saw; `None` for no window.
    pub(crate) fn summarise(recorder: &Recorder, projector: &Projector) -> Option<Self> {
        let (windows, rough_permille) = recorder.windows;
        (windows > 0).then(|| Self {
            windows,
            roughness: rough_permille as f64 * 1e-3 / f64::from(windows),
            rested_pulses: projector.rested_pulses(),
            taps: projector.taps(),
            extrapolated: Vec::new(),
        })
    }

    /// Adds the properties of the scene's surface that its model never learned.
    ///
    /// # Errors
    /// A model that cannot be read again.
    pub(crate) fn compared(&mut self, setup: &Setup) -> Result<(), Failure> {
        let felt = setup.scene.value.texture.as_ref();
        let surface = setup.texture.as_ref().and_then(|t| t.surface.as_ref());
        if let (Some(felt), Some(surface)) = (felt, surface) {
            self.extrapolated = TextureModel::open(&felt.model)?.extrapolated(surface);
        }
        Ok(())
    }

    /// Words of the properties of the surface outside the model's range; `None` where it knows them all.
    pub(crate) fn unknown(&self) -> Option<String> {
        let all = self.extrapolated.join(", ");
        (!all.is_empty()).then(|| format!("EXTRAPOLATED: {all}"))
    }

    /// Words of the figures, in one line.
    pub(crate) fn words(&self) -> String {
        let rested = match self.rested_pulses {
            0 => String::new(),
            n => format!("; {n} pulses left out, wires rest after 48 ms"),
        };
        let taps = match self.taps {
            0 => String::new(),
            1 => "; 1 tap of hardness".to_owned(),
            n => format!("; {n} taps of hardness"),
        };
        let outside = self
            .unknown()
            .map_or_else(String::new, |all| format!("; {all}"));
        format!(
            "{} windows, roughness {:.2} (mean){taps}{rested}{outside}",
            self.windows, self.roughness
        )
    }
}
