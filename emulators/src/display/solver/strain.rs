//! Strain of a wire by parts, and the motion of the skin that it makes.

use palpate_core::physics::Bow;

/// Parts of the strain, 1; positive is longer.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Strain {
    /// Elastic strain sigma / E(xi), with the Reuss mean of the two moduli; sigma / E of martensite for a wire with a
    /// history, by its bow.
    pub elastic: f64,
    /// Sum of the phases' strains.
    pub phase: f64,
    /// Thermal strain alpha(xi) (T - T0). Over a band it is straightened (see [`super::plays`]).
    pub thermal: f64,
}

impl Strain {
    /// Sum of the parts.
    pub fn total(&self) -> f64 {
        self.elastic + self.phase + self.thermal
    }
}

/// The skin over a stretch of time in which neither hysteresis nor contact changes: `at_m + m_per_k (T - from_c)`,
/// with T the wire's temperature in degrees C. Positive is into the skin.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Motion {
    /// Displacement from rest at `from_c`, m.
    pub at_m: f64,
    /// Change of the displacement with the wire's temperature, m/K; 0 while skin and wire are apart.
    pub m_per_k: f64,
    /// Temperature that it is counted from, degrees C.
    pub from_c: f64,
}

impl Motion {
    /// Displacement at a wire temperature of the stretch, m.
    pub fn at(&self, wire_c: f64) -> f64 {
        self.at_m + self.m_per_k * (wire_c - self.from_c)
    }
}

/// A wire on the skin.
#[derive(Clone, Copy, Debug)]
pub struct Worn {
    /// Displacement over strain, m.
    gain_m: f64,
    /// Strain at which wire and skin were put together, 1.
    rest: f64,
    /// Strain over which skin and wire are apart, 1.
    parting: f64,
    /// Displacement at that strain, m.
    pub(super) parting_m: f64,
    /// Displacement of the bow from its sag when wire and skin were put together, m.
    pub(super) rest_m: f64,
}

/// Distance of strains that count as one; rounding is a hundredth of it.
const SAME: f64 = 1e-15;

impl Worn {
    /// A wire of this length that lies on the skin at a strain, its bow `rest_m` from its sag.
    pub fn new(bow: &Bow, length_m: f64, rest: f64, rest_m: f64) -> Self {
        let gain_m = bow.gain * length_m;
        Self {
            gain_m,
            rest,
            parting: rest - bow.parting_m / gain_m,
            parting_m: bow.parting_m,
            rest_m,
        }
    }

    /// The skin from a wire temperature `t` on, where the strain is `strain` and changes by `per_k`, while the
    /// temperature `rises` or falls. The two temperatures are those between which it holds; skin and wire part or
    /// meet there.
    pub fn motion(&self, t: f64, strain: f64, per_k: f64, rises: bool) -> (Motion, (f64, f64)) {
        let over = strain - self.parting;
        let here = over.abs() <= SAME;
        let apart = if here {
            (per_k > 0.0) == rises
        } else {
            over > 0.0
        };
        let motion = if apart {
            Motion {
                at_m: self.parting_m,
                m_per_k: 0.0,
                from_c: t,
            }
        } else {
            Motion {
                at_m: self.gain_m * (self.rest - strain),
                m_per_k: -self.gain_m * per_k,
                from_c: t,
            }
        };
        let change = t - over / per_k;
        // A point at which both just met or parted lies behind, whatever rounding makes of it.
        let between = match change.is_finite() {
            true if here && rises => (change.min(t), f64::INFINITY),
            true if here => (f64::NEG_INFINITY, change.max(t)),
            true if change > t => (f64::NEG_INFINITY, change),
            true => (change, f64::INFINITY),
            false => (f64::NEG_INFINITY, f64::INFINITY),
        };
        (motion, between)
    }
}
