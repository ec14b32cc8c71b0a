//! One burst of pulses as a wire remembers it.

use crate::time::Nanos;

/// One burst of pulses on one wire.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WireBurst {
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
