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
    /// Lower than any.
    pub const NONE: Self = Self {
        wire_c: f64::NEG_INFINITY,
        shallow_c: f64::NEG_INFINITY,
        deep_c: f64::NEG_INFINITY,
    };

    /// Takes over what is higher.
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
    /// Electrical energy between the terminals.
    pub electrical_j: f64,
    /// The part of it that heated the wire.
    pub wire_j: f64,
    /// Lost to the air.
    pub air_j: f64,
    /// Lost to ends and mount.
    pub ends_j: f64,
    /// Carried away by the body.
    pub body_j: f64,
    /// Sensible heat in wire and shells above body temperature, now.
    pub stored_j: f64,
    /// Latent heat in the wire above martensite, now.
    pub latent_j: f64,
}
