//! Straight lines of the law of phases: ranges of temperature, and the direction in which it goes.

/// Direction in which the wire's temperature goes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Heading {
    /// Heating.
    Up,
    /// Cooling.
    Down,
}

/// A range of temperature in which the law is one straight line.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Branch {
    /// d xi/dT of the martensite, 1/K; never positive.
    pub slope: f64,
    /// Latent heat that a kelvin takes up or releases, J/K; never negative.
    pub latent: f64,
    /// Change of the total strain, 1/K.
    pub strain: f64,
    /// Lower end of the range, degrees C.
    pub low: f64,
    /// Upper end of the range, degrees C.
    pub high: f64,
    /// True if the branch ends when the temperature turns.
    pub one_way: bool,
}
