//! The seat of a bench's wires on the finger, and the finger itself.

use palpate_core::guard::WornWire;
use palpate_core::physics::{DEEPEST, Ends, Mount, TissueParameters};

use super::error::FileError;
use super::settings::{bounds, settings};
use super::source::Source;
use super::words;

/// The warmest that a finger at rest may be unless stated, degrees C. Fingertips are found at 27 to 31 C by posture.
const WARMEST_C: f64 = 33.0;

settings! {
    /// The bow of a wire between its crimps. Left out: assumed values.
    #[derive(Copy)]
    pub struct BenchMount {
        /// Height of the bow over the straight line between both crimps, micrometres.
        pub sag_um: f64 = 170.0,
        /// The mounting of the wire's ends in the crimps.
        #[serde(with = "words::Ends")]
        pub ends: Ends = Ends::Clamped,
        /// Force with which a wire lies on the skin at rest, mN.
        pub preload_mn: f64 = 1.0,
        /// Way by which the thimble gives under a wire's force, micrometres per mN; 0 is rigid.
        pub compliance_um_per_mn: f64 = 0.0,
    }
}

settings! {
    /// The finger under the wires. Left out: assumed values.
    #[derive(Copy)]
    pub struct BenchTissue {
        /// Young's modulus, kPa.
        pub modulus_kpa: f64 = 100.0,
        /// Width of the strip on which wire and skin touch, micrometres.
        pub contact_um: f64 = 60.0,
        /// Temperature of the emulated finger at rest, degrees C.
        pub rest_c: f64 = 30.0,
        /// The warmest that the finger at rest may be, degrees C: the guard counts from here. Left out: 33, or `rest_c`
        /// where that is warmer.
        pub warmest_c: Option<f64>,
    }
}

impl BenchMount {
    /// Checks that a wire of this length can have such a bow.
    ///
    /// # Errors
    /// Names key and range.
    pub(super) fn fits(&self, source: &Source, length_mm: f64) -> Result<(), FileError> {
        let deepest = length_mm * 1e3 * DEEPEST;
        bounds!(source, "mount", self; sag_um: 1.0..=deepest, "um, a fifth of the wire's length")
    }

    /// Parameters of the model's mount.
    #[must_use]
    pub fn parameters(&self) -> Mount {
        Mount {
            sag_m: self.sag_um / 1e6,
            ends: self.ends,
            preload_n: self.preload_mn / 1e3,
            compliance_m_per_n: self.compliance_um_per_mn / 1e3,
        }
    }
}

impl BenchTissue {
    pub(super) fn check(&self, source: &Source) -> Result<(), FileError> {
        let (coldest, warmest) = WornWire::REST_MC.into_inner();
        let celsius = |mc: u32| f64::from(mc) / 1e3;
        bounds!(source, "tissue", self;
            modulus_kpa: 1.0..=10_000.0, "kPa";
            contact_um: 1.0..=500.0, "um";
            rest_c: celsius(coldest)..=celsius(warmest), "C: the guard has rows of heat for no other finger";
            warmest_c: self.rest_c..=celsius(warmest), "C: no colder than rest_c, with rows of heat in the guard")
    }

    /// Temperature of the finger at rest from which the guard counts, degrees C.
    #[must_use]
    pub fn guarded_c(&self) -> f64 {
        self.warmest_c.unwrap_or(WARMEST_C.max(self.rest_c))
    }

    /// Parameters of the model's tissue.
    #[must_use]
    pub fn parameters(&self) -> TissueParameters {
        TissueParameters {
            modulus_pa: self.modulus_kpa * 1e3,
            contact_width_m: self.contact_um / 1e6,
            body_c: self.rest_c,
            ..TissueParameters::DEFAULT
        }
    }
}

#[cfg(test)]
#[path = "mount_tests.rs"]
mod tests;
