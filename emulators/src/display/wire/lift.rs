//! How far a wire moves the tissue.

use palpate_core::physics::WireParameters;

/// Displacement of the tissue per change of the wire's length, 1. **Fitted**: the 0.46 um of a pulse of the published full
/// drive become the 10 um that were seen on the first prototype.
const FITTED_GAIN: f64 = 21.6;

/// Displacement of the tissue per kelvin of the wire, um/K: thermal expansion as austenite alone, which is what the gain was
/// fitted with.
pub fn um_per_kelvin(wire: &WireParameters) -> f64 {
    FITTED_GAIN * wire.mechanics.expansion_austenite * wire.length_m * 1e6
}
