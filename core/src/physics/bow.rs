//! Bow of a wire: its length moves the skin as a shallow bow between fixed ends, with tissue under it.
//!
//! A wire that grows by dL bows out by 2 L / (pi^2 s) dL if nothing holds it. Its own bending and the tissue hold it:
//! the bow keeps the share of its stiffness against stretching, K_g, in all stiffnesses. `ci/peers/run bow` holds the
//! gain against a finite-difference beam.

use core::f64::consts::PI;

use super::{ParameterError, TissueParameters, WireParameters, check, not_negative, positive};

/// Mountings of a wire's ends.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Ends {
    /// Ends that cannot turn: the shape is (s/2)(1 - cos 2 pi x/L).
    Clamped,
    /// Ends that turn freely: the shape is s sin(pi x/L).
    Pinned,
    /// Ends that cannot turn, with the wire pressed to its buckling load: bending resists no more.
    Buckled,
}

/// The seat of a wire in the thimble.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Mount {
    /// Height of the bow over the straight line between both ends, m \[A\]; stated range 20e-6 to 400e-6.
    pub sag_m: f64,
    /// Mounting of the ends \[A\].
    pub ends: Ends,
    /// Force with which the wire lies on the skin at rest, N \[A\].
    pub preload_n: f64,
    /// Way by which the thimble gives under a wire's force, m/N \[A\]; 0 is rigid.
    pub compliance_m_per_n: f64,
}

impl Mount {
    /// The seat with clamped ends, 1 mN, and a sag at which 75 um of wire have the gain 5 that the published range
    /// centres on.
    pub const DEFAULT: Self = Self {
        sag_m: 170e-6,
        ends: Ends::Clamped,
        preload_n: 1e-3,
        compliance_m_per_n: 0.0,
    };

    /// Checks that the model can compute with every value.
    pub(super) fn check(&self, length_m: f64) -> Result<(), ParameterError> {
        positive("mount.sag_m", self.sag_m)?;
        check("mount.sag_m", self.sag_m <= length_m * DEEPEST)?;
        not_negative("mount.preload_n", self.preload_n)?;
        not_negative("mount.compliance_m_per_n", self.compliance_m_per_n)
    }
}

/// Deepest bow that is still shallow, as a part of its length: there the excess length is a tenth.
pub const DEEPEST: f64 = 0.2;

/// Displacement that bow and tissue make of a change of length. It is positive into the skin, where a wire over a
/// convex finger goes as it shortens.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bow {
    /// Displacement of the skin over the wire's change of length, 1.
    pub gain: f64,
    /// Displacement of a free wire, without skin, over its change of length, 1.
    pub free_gain: f64,
    /// Force over displacement of the tissue under the whole wire, N/m.
    pub line_n_per_m: f64,
    /// Part of the bow's displacement that the skin takes; the thimble gives way by the rest.
    pub skin_share: f64,
    /// Displacement from rest at which skin and wire part, m; not positive.
    pub parting_m: f64,
}

impl Bow {
    /// The bow of a wire on a finger, by its martensite's modulus.
    ///
    /// # Errors
    /// A parameter that cannot be computed with.
    pub fn new(wire: &WireParameters, tissue: &TissueParameters) -> Result<Self, ParameterError> {
        wire.check()?;
        tissue.check()?;
        let (d, length, sag) = (wire.diameter_m, wire.length_m, wire.mount.sag_m);
        let modulus = wire.mechanics.modulus_martensite_pa;
        let cube = length * length * length;
        let pi_4 = PI * PI * PI * PI;
        let section = PI / 4.0 * d * d;
        let second_moment = PI / 64.0 * d * d * d * d;
        let stretching = modulus * section * pi_4 * sag * sag / (4.0 * cube);
        // Each share of the tissue's stiffness is the mean square of the shape over that of its middle.
        let (held, shape) = match wire.mount.ends {
            Ends::Clamped => (1.0, 3.0 / 8.0),
            Ends::Pinned => (0.25, 0.5),
            Ends::Buckled => (0.0, 3.0 / 8.0),
        };
        let bending = held * 2.0 * modulus * second_moment * pi_4 / cube;
        let line_n_per_m = line_stiffness(tissue, length)?;
        let free = 2.0 * length / (PI * PI * sag);
        // Tissue and thimble are springs in series: the force that the tissue makes moves the crimps too.
        let skin_share = 1.0 / (1.0 + wire.mount.compliance_m_per_n * line_n_per_m);
        let tissue = shape * line_n_per_m * skin_share;
        Ok(Self {
            gain: free * stretching / (stretching + bending + tissue) * skin_share,
            free_gain: free * stretching / (stretching + bending),
            line_n_per_m,
            skin_share,
            parting_m: -wire.mount.preload_n / line_n_per_m,
        })
    }
}

/// Force over displacement of a half-space under a strip of a wire's length and the contact's width, N/m:
/// pi E* (L/2) / K(m) with m = 1 - (b/L)^2 (an elliptic contact), E* = E / 0.75 (no change of volume).
fn line_stiffness(tissue: &TissueParameters, length_m: f64) -> Result<f64, ParameterError> {
    let slender = tissue.contact_width_m / length_m;
    check("contact_width_m", slender <= 1.0)?;
    // K(m) = pi / (2 M(1, sqrt(1 - m))), M the arithmetic-geometric mean, which converges in a few steps.
    let (mut mean, mut root) = (1.0, slender);
    for _ in 0..8 {
        (mean, root) = (f64::midpoint(mean, root), libm::sqrt(mean * root));
    }
    Ok(tissue.modulus_pa / 0.75 * length_m * mean)
}

#[cfg(test)]
#[path = "bow_tests.rs"]
mod tests;
