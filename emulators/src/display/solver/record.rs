//! Records of a wire's run: maxima over continuous time and the energy ledger.

/// Maxima over continuous time, degrees C.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Peaks {
    /// The wire.
    pub wire_c: f64,
    /// The tissue 0.1 mm under its surface.
    pub shallow_c: f64,
    /// The tissue 0.4 mm under its surface.
    pub deep_c: f64,
}

impl Peaks {
    /// Peaks that are lower than any.
    pub const NONE: Self = Self {
        wire_c: f64::NEG_INFINITY,
        shallow_c: f64::NEG_INFINITY,
        deep_c: f64::NEG_INFINITY,
    };

    /// Takes over each peak that is higher.
    pub fn raise(&mut self, other: &Self) {
        self.wire_c = self.wire_c.max(other.wire_c);
        self.shallow_c = self.shallow_c.max(other.shallow_c);
        self.deep_c = self.deep_c.max(other.deep_c);
    }
}

/// Energy ledger since the start, J. `wire_j` is the sum of the change in `stored_j` and `latent_j` and of what
/// flowed to air, ends and body.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Energy {
    /// Electrical energy between the terminals, J.
    pub electrical_j: f64,
    /// Part of it that heated the wire, J.
    pub wire_j: f64,
    /// Energy lost to the air, J.
    pub air_j: f64,
    /// Energy lost to ends and mount, J.
    pub ends_j: f64,
    /// Energy carried away by the body, J.
    pub body_j: f64,
    /// Sensible heat in wire and shells above body temperature, now, J.
    pub stored_j: f64,
    /// Latent heat in the wire above martensite, now, J.
    pub latent_j: f64,
}
