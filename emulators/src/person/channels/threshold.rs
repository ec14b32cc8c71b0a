//! Threshold of the Pacinian channel by the area that moves. It adds up energy over area as over time: a larger contact is
//! felt at a smaller amplitude (Gescheider 1994, 2002). NP I does not.

/// Area up to which `summation` holds, cm2.
const KNEE_CM2: f64 = 0.1;
/// Exponent of larger areas. Assumed.
const ABOVE_KNEE: f64 = 0.25;

/// A threshold, the contact that it was measured with, and its way with the area.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AreaThreshold {
    /// Amplitude of a long sine at 250 Hz that is just felt, um.
    pub um: f64,
    /// Area of the contact for which it holds, cm2.
    pub area_cm2: f64,
    /// Exponent by which the amplitude falls with the area up to 0.1 cm2: 1/2 are 3 dB per doubling.
    pub summation: f64,
}

impl AreaThreshold {
    /// Threshold of a contact of another area, um. Not finite where either area is not above 0.
    pub fn at(&self, area_cm2: f64) -> f64 {
        self.um * self.factor(area_cm2) / self.factor(self.area_cm2)
    }

    /// Threshold relative to the one at 0.1 cm2, 1.
    fn factor(&self, area_cm2: f64) -> f64 {
        let exponent = match area_cm2 > KNEE_CM2 {
            true => ABOVE_KNEE,
            false => self.summation,
        };
        libm::pow(KNEE_CM2 / area_cm2, exponent)
    }
}

#[cfg(test)]
#[path = "threshold_tests.rs"]
mod tests;
