//! A bench's `[heat]`: a Peltier module under the fingertip.

use palpate_core::physics::PeltierParameters;
use serde::Deserialize;

use super::super::error::FileError;
use super::super::source::Source;

/// A Peltier module between fingertip and sink: 10 x 10 mm, 17 couples. Left out: there is none. Emulated benches of one
/// display, and driver units.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(default, deny_unknown_fields)]
pub struct BenchHeat {
    /// Air at the sink, degrees C.
    pub air_c: f64,
    /// From the sink to the air, K/W.
    pub sink_k_w: f64,
    /// Heat capacity of the sink, J/K.
    pub sink_j_k: f64,
    /// From the face through the skin to the body, W/K.
    pub skin_w_k: f64,
}

impl Default for BenchHeat {
    /// A small finned sink on the finger's back, and a fingertip: all assumed.
    fn default() -> Self {
        let assumed = PeltierParameters::default();
        Self {
            air_c: 25.0,
            sink_k_w: assumed.sink_k_w,
            sink_j_k: assumed.sink_j_k,
            skin_w_k: assumed.skin_w_k,
        }
    }
}

impl BenchHeat {
    pub(super) fn check(&self, source: &Source) -> Result<(), FileError> {
        source.range("heat.air_c", self.air_c, 0.0..=40.0, "C")?;
        source.range("heat.sink_k_w", self.sink_k_w, 0.1..=100.0, "K/W")?;
        source.range("heat.sink_j_k", self.sink_j_k, 1.0..=1000.0, "J/K")?;
        source.range("heat.skin_w_k", self.skin_w_k, 0.001..=0.1, "W/K")
    }

    /// The module in the core's terms.
    #[must_use]
    pub fn parameters(&self) -> PeltierParameters {
        PeltierParameters {
            sink_k_w: self.sink_k_w,
            sink_j_k: self.sink_j_k,
            skin_w_k: self.skin_w_k,
            ..PeltierParameters::default()
        }
    }
}
