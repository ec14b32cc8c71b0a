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
mod tests {
    use super::*;

    #[test]
    fn it_runs_from_guessing_to_all_but_slips() {
        let felt = Psychometric {
            threshold: -12.0,
            slope: 3.5,
            guess: 0.5,
            lapse: 0.02,
        };
        assert!((felt.correct(-80.0) - 0.5).abs() < 1e-4);
        assert!((felt.correct(20.0) - 0.98).abs() < 1e-9);
        // At the threshold: 1 - 1/e of the way.
        let way = (felt.correct(-12.0) - 0.5) / 0.48;
        assert!((way - (1.0 - (-1.0f64).exp())).abs() < 1e-12);
    }
}
