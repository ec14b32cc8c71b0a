//! Strain of a wire from its phase and temperature.

use palpate_core::physics::WireParameters;

/// Parts of the strain, 1; positive is longer.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Strain {
    /// sigma / E(xi), Reuss mean of the two moduli.
    pub elastic: f64,
    /// eps_L xi.
    pub phase: f64,
    /// alpha(xi) (T - T0).
    pub thermal: f64,
}

impl Strain {
    /// At `t` degrees C and martensite fraction `xi`.
    pub fn of(wire: &WireParameters, t: f64, xi: f64) -> Self {
        let m = &wire.mechanics;
        let compliance = xi / m.modulus_martensite_pa + (1.0 - xi) / m.modulus_austenite_pa;
        let expansion = xi * m.expansion_martensite + (1.0 - xi) * m.expansion_austenite;
        Self {
            elastic: wire.bias_stress_pa * compliance,
            phase: m.transformation_strain * xi,
            thermal: expansion * (t - m.rest_c),
        }
    }

    /// Their sum.
    pub fn total(&self) -> f64 {
        self.elastic + self.phase + self.thermal
    }
}
