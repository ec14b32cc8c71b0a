//! The rows of heat for the wire that is guarded: the effect of a joule in it on the tissue, and that tissue at rest.
//!
//! The sums of decays in [`table`](super::table) are of a few diameters, each at three lengths. This module
//! interpolates between them in straight lines. Wire and tissue scale with the length, except for the heat that the
//! ends take: the longer the wire, the less, as one over the length squared. A joule's warmth falls with that share
//! as a sum of exponentials, and such a sum lies below its chord. A figure between two lengths is therefore never
//! below the wire's own. A test shows the same of diameters.

use core::ops::RangeInclusive;

use super::PlantError;
use super::decays::Decays;
use super::table::{DIAMETERS_NM, LENGTHS, ROWS};
use crate::physics::{TissueParameters, WireParameters};

/// Temperature of a finger at rest unless stated, degrees C.
pub(super) const REST_C: f64 = 33.0;
/// The length, um, for which [`ROWS`] count a joule.
const UNIT_UM: f64 = 5000.0;

/// A wire on a finger, as the guard's rows of heat know it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct WornWire {
    /// Diameter, nanometres.
    pub diameter_nm: u32,
    /// Length between the crimps, micrometres.
    pub length_um: u32,
    /// The finger at rest, millidegrees Celsius. The guard never expects it warmer.
    pub rest_mc: u32,
}

impl Default for WornWire {
    /// The final module's wire, 75 um and 5 mm, on a finger of 33 C.
    fn default() -> Self {
        Self {
            diameter_nm: 75_000,
            length_um: 5_000,
            rest_mc: 33_000,
        }
    }
}

/// The effect of a joule on the tissue under one wire, and that tissue at rest.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Kernel {
    /// Tissue at rest, degrees C.
    pub(super) rest_c: f64,
    /// Temperature that a joule's share in each decay makes at 0.1 mm, K/J.
    pub(super) shallow: Decays,
    /// Temperature that a joule's share in each decay makes at 0.4 mm, K/J.
    pub(super) deep: Decays,
}

impl WornWire {
    /// Diameters that the guard has rows for, nanometres.
    pub const DIAMETER_NM: RangeInclusive<u32> =
        DIAMETERS_NM[0]..=DIAMETERS_NM[DIAMETERS_NM.len() - 1];
    /// Lengths that the guard has rows for, micrometres.
    pub const LENGTH_UM: RangeInclusive<u32> = 3_000..=20_000;
    /// Fingers at rest that the guard has rows for, millidegrees Celsius.
    pub const REST_MC: RangeInclusive<u32> = 26_000..=36_000;

    /// A modelled wire on a modelled finger.
    pub fn new(wire: &WireParameters, tissue: &TissueParameters) -> Self {
        let whole = |x: f64| libm::round(x) as u32;
        Self {
            diameter_nm: whole(wire.diameter_m * 1e9),
            length_um: whole(wire.length_m * 1e6),
            rest_mc: whole(tissue.body_c * 1e3),
        }
    }

    /// Checks that the guard has rows of heat for this wire.
    ///
    /// # Errors
    /// The figure that lies outside what the table was made for.
    pub fn check(&self) -> Result<(), PlantError> {
        if !Self::DIAMETER_NM.contains(&self.diameter_nm) {
            return Err(PlantError::Diameter);
        }
        if !Self::LENGTH_UM.contains(&self.length_um) {
            return Err(PlantError::Length);
        }
        if !Self::REST_MC.contains(&self.rest_mc) {
            return Err(PlantError::Rest);
        }
        Ok(())
    }

    /// Interpolates the wire's rows of heat.
    ///
    /// # Errors
    /// The errors of [`Self::check`].
    pub(super) fn kernel(&self) -> Result<Kernel, PlantError> {
        self.check()?;
        let over = UNIT_UM / f64::from(self.length_um);
        let (thin, thick) = between(&DIAMETERS_NM.map(f64::from), self.diameter_nm.into());
        let (long, short) = between(&LENGTHS, over * over);
        let row = |depth: usize| -> Decays {
            core::array::from_fn(|k| {
                let at = |(n, share): (usize, f64)| {
                    let of = |(m, part): (usize, f64)| part * ROWS[n][m][depth][k];
                    share * (of(long) + of(short))
                };
                over * (at(thin) + at(thick))
            })
        };
        Ok(Kernel {
            rest_c: f64::from(self.rest_mc) * 1e-3,
            shallow: row(0),
            deep: row(1),
        })
    }
}

/// The two neighbours of `x` among rising knots, and the share of each. The knots reach from below `x` to beyond it.
fn between(knots: &[f64], x: f64) -> ((usize, f64), (usize, f64)) {
    let above = knots.partition_point(|knot| *knot <= x);
    let above = above.clamp(1, knots.len() - 1);
    let (low, high) = (knots[above - 1], knots[above]);
    let share = (x - low) / (high - low);
    ((above - 1, 1.0 - share), (above, share))
}

#[cfg(test)]
#[path = "kernel_tests.rs"]
pub(super) mod tests;
