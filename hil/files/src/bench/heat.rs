//! A bench's `[heat]`: a Peltier module under the fingertip.

use palpate_core::physics::PeltierParameters;

use super::super::error::FileError;
use super::super::settings::{bounds, settings};
use super::super::source::Source;

settings! {
    /// A Peltier module between fingertip and sink: 10 x 10 mm, 17 couples. Left out: there is none. Emulated benches of one
    /// display, and driver units.
    #[derive(Copy)]
    pub struct BenchHeat {
        /// Air at the sink, degrees C.
        pub air_c: f64 = 25.0,
        /// Thermal resistance from the sink to the air, K/W.
        pub sink_k_w: f64 = PeltierParameters::default().sink_k_w,
        /// Heat capacity of the sink, J/K.
        pub sink_j_k: f64 = PeltierParameters::default().sink_j_k,
        /// Thermal conductance from the face through the skin to the body, W/K.
        pub skin_w_k: f64 = PeltierParameters::default().skin_w_k,
    }

    /// A small finned sink on the finger's back, and a fingertip: all assumed.
    default
}

impl BenchHeat {
    pub(super) fn check(&self, source: &Source) -> Result<(), FileError> {
        bounds!(source, "heat", self;
            air_c: 0.0..=40.0, "C";
            sink_k_w: 0.1..=100.0, "K/W";
            sink_j_k: 1.0..=1000.0, "J/K";
            skin_w_k: 0.001..=0.1, "W/K")
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
