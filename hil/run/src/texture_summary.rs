//! What was felt of textures, as a summary has it.

use palpate_core::projector::Projector;
use serde::Serialize;

use crate::recorder::Recorder;

/// What was felt of a texture.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct TextureSummary {
    /// Windows that went through the network and were felt.
    pub windows: u32,
    /// Mean roughness, 0 to 1.
    pub roughness: f64,
    /// Pulses that were left out for a wire to rest.
    pub rested_pulses: u64,
}

impl TextureSummary {
    /// Of the windows that a recorder saw.
    pub(crate) fn of(recorder: &Recorder, projector: &Projector) -> Option<Self> {
        let (windows, rough_permille) = recorder.windows;
        (windows > 0).then(|| Self {
            windows,
            roughness: rough_permille as f64 * 1e-3 / f64::from(windows),
            rested_pulses: projector.rested_pulses(),
        })
    }

    /// In one line.
    pub(crate) fn words(&self) -> String {
        let rested = match self.rested_pulses {
            0 => String::new(),
            n => format!("; {n} pulses left out, wires rest after 48 ms"),
        };
        format!(
            "{} windows, roughness {:.2} (mean){rested}",
            self.windows, self.roughness
        )
    }
}
