//! Probability of a felt stimulus, by its level: the Weibull function on a scale of decibels.

/// A psychometric function: the probability of a correct answer by the level of the stimulus.
///
/// Watson & Pelli 1983, as QUEST+ (Watson 2017, eq. 17) writes it for decibels:
/// `p(x) = 1 - lapse - (1 - guess - lapse) exp(-10^(slope (x - threshold) / 20))`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Psychometric {
    /// Level, dB, at which 63 % of the way from guessing to certainty is gone.
    pub threshold: f64,
    /// Steepness, per decade of amplitude.
    pub slope: f64,
    /// Probability of a correct answer without a stimulus: 0.5 between two intervals.
    pub guess: f64,
    /// Probability of a slip however strong the stimulus is.
    pub lapse: f64,
}

impl Psychometric {
    /// Probability of a correct answer at a level, dB.
    pub fn correct(&self, level: f64) -> f64 {
        let strength = libm::pow(10.0, self.slope * (level - self.threshold) / 20.0);
        1.0 - self.lapse - (1.0 - self.guess - self.lapse) * libm::exp(-strength)
    }

    /// Distance from the threshold to the middle between guessing and certainty, dB.
    pub(crate) fn halfway(&self) -> f64 {
        20.0 / self.slope * libm::log10(core::f64::consts::LN_2)
    }
}

#[cfg(test)]
#[path = "psychometric_tests.rs"]
mod tests;
