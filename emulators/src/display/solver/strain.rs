//! Strain of a wire by parts, and the motion of the skin that it makes.

/// Parts of the strain, 1; positive is longer.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Strain {
    /// sigma / E of martensite, as the bow has it.
    pub elastic: f64,
    /// Sum of the phases' strains.
    pub phase: f64,
    /// alpha(xi) (T - T0). Over a band it is straightened (see [`palpate_core::physics::Law`]).
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

/// A wire on the skin: displacements of its bow from its sag.
#[derive(Clone, Copy, Debug)]
pub struct Worn {
    /// Displacement at which skin and wire part, m.
    pub parting_m: f64,
    /// Displacement at which both were put together, m.
    pub rest_m: f64,
}
