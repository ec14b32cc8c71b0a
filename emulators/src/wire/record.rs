//! What is remembered of a wire's run: maxima over continuous time, the energy ledger, bursts.

use crate::time::Nanos;

/// Maxima over continuous time, degrees C.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Peaks {
    /// The wire.
    pub wire_c: f64,
    /// The skin 0.1 mm under its surface.
    pub shallow_c: f64,
    /// The skin 0.4 mm under its surface.
    pub deep_c: f64,
}

impl Peaks {
    /// Takes over what is higher.
    pub fn raise(&mut self, other: &Self) {
        self.wire_c = self.wire_c.max(other.wire_c);
        self.shallow_c = self.shallow_c.max(other.shallow_c);
        self.deep_c = self.deep_c.max(other.deep_c);
    }
}

/// Where the energy went since the start, J. `wire_j` is the sum of the change in `stored_j` and
/// `latent_j` and of what flowed to air, ends and body.
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

/// One burst of pulses on one wire.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Burst {
    /// The first rising edge.
    pub start: Nanos,
    /// The last falling edge so far.
    pub end: Nanos,
    /// Pulses completed.
    pub pulses: u32,
    /// Electrical energy between the terminals, J.
    pub electrical_j: f64,
    /// Energy into the wire, J.
    pub wire_j: f64,
    /// Hottest the wire was at a falling edge, degrees C.
    pub hottest_c: f64,
    /// Mean rise of the wire's temperature in a pulse, K.
    pub ripple_k: f64,
    /// Largest rise of the wire's temperature in a pulse, K.
    pub ripple_max_k: f64,
    /// Mean change of strain in a pulse, thermal part only, 1.
    pub thermal_strain: f64,
    /// Mean change of strain in a pulse, all parts (thermal, phase, elastic), absolute value, 1.
    pub strain: f64,
}
