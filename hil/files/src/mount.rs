//! How a bench's wires sit on the finger, and the finger itself.

use palpate_core::physics::{DEEPEST, Ends, Mount, TissueParameters};
use serde::Deserialize;

use super::error::FileError;
use super::source::Source;
use super::words;

/// The bow of a wire between its crimps. Left out: assumed values.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(default, deny_unknown_fields)]
pub struct BenchMount {
    /// Height of the bow over the straight line between both crimps, micrometres.
    pub sag_um: f64,
    /// How the crimps hold the wire.
    #[serde(with = "words::Ends")]
    pub ends: Ends,
    /// Force with which a wire lies on the skin at rest, mN.
    pub preload_mn: f64,
}

impl Default for BenchMount {
    fn default() -> Self {
        Self {
            sag_um: 170.0,
            ends: Ends::Clamped,
            preload_mn: 1.0,
        }
    }
}

/// The finger as an elastic body. Left out: assumed values.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(default, deny_unknown_fields)]
pub struct BenchTissue {
    /// Young's modulus, kPa.
    pub modulus_kpa: f64,
    /// Width of the strip on which wire and skin touch, micrometres.
    pub contact_um: f64,
}

impl Default for BenchTissue {
    fn default() -> Self {
        Self {
            modulus_kpa: 100.0,
            contact_um: 60.0,
        }
    }
}

impl BenchMount {
    pub(super) fn check(&self, source: &Source) -> Result<(), FileError> {
        source.range("mount.sag_um", self.sag_um, 1.0..=10_000.0, "um")?;
        source.range("mount.preload_mn", self.preload_mn, 0.0..=100.0, "mN")
    }

    /// Whether a wire of this length can have such a bow.
    ///
    /// # Errors
    /// Names key and range.
    pub(super) fn fits(&self, source: &Source, length_mm: f64) -> Result<(), FileError> {
        let deepest = length_mm * 1e3 * DEEPEST;
        source.range(
            "mount.sag_um",
            self.sag_um,
            1.0..=deepest,
            "um, a fifth of the wire's length",
        )
    }

    /// As the model takes it.
    #[must_use]
    pub fn parameters(&self) -> Mount {
        Mount {
            sag_m: self.sag_um / 1e6,
            ends: self.ends,
            preload_n: self.preload_mn / 1e3,
        }
    }
}

impl BenchTissue {
    pub(super) fn check(&self, source: &Source) -> Result<(), FileError> {
        source.range(
            "tissue.modulus_kpa",
            self.modulus_kpa,
            1.0..=10_000.0,
            "kPa",
        )?;
        source.range("tissue.contact_um", self.contact_um, 1.0..=500.0, "um")
    }

    /// As the model takes it: heat as ever.
    #[must_use]
    pub fn parameters(&self) -> TissueParameters {
        TissueParameters {
            modulus_pa: self.modulus_kpa * 1e3,
            contact_width_m: self.contact_um / 1e6,
            ..TissueParameters::DEFAULT
        }
    }
}

#[cfg(test)]
#[path = "mount_tests.rs"]
mod tests;
