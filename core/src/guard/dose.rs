//! Burn integrals of the skin 0.1 mm under one wire over a session, from above: Henriques' Omega and CEM43.

use crate::physics::{GAS_CONSTANT, HENRIQUES_A, HENRIQUES_EA, LN_HENRIQUES_A, ZERO_CELSIUS_K};

/// The dose left is never spent faster than in this time, s: a wire near its dose limit fades with it, and
/// what cooling skin still adds to its dose after the last burst (a few seconds' worth) is well covered.
const HORIZON_S: f64 = 60.0;

/// Most dose of a session.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct DoseLimits {
    pub(super) omega: f64,
    pub(super) cem43_min: f64,
}

impl DoseLimits {
    /// So much dose left lasts for [`HORIZON_S`] at `mc` millidegrees C, and a thousandth more, which no rounding
    /// takes.
    pub(super) fn ample(mc: u64) -> Self {
        let rates = Rates::at(mc as f64 * 1e-3);
        Self {
            omega: 1.001 * HORIZON_S * rates.omega,
            cem43_min: 1.001 * HORIZON_S * rates.cem43_min,
        }
    }
}

/// Dose so far, and its rates at the skin's present temperature.
#[derive(Clone, Debug)]
pub(super) struct Dose {
    pub(super) omega: f64,
    pub(super) cem43_min: f64,
    rates: Rates,
}

/// Dose a second.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Rates {
    omega: f64,
    cem43_min: f64,
}

impl Rates {
    /// At `t` degrees C. CEM43 is continued below 39 C, where it is zero, with the law from above: it is
    /// convex then, and a millionth a minute at rest.
    fn at(t: f64) -> Self {
        let exponent = HENRIQUES_EA / (GAS_CONSTANT * (t + ZERO_CELSIUS_K));
        let above = t - 43.0; // below 43 C a degree halves the rate twice
        let doublings = above.min(2.0 * above);
        Self {
            omega: HENRIQUES_A * libm::exp(-exponent),
            cem43_min: libm::exp2(doublings) / 60.0,
        }
    }
}

impl Dose {
    /// None so far, with skin at `t` degrees C.
    pub(super) fn new(t: f64) -> Self {
        Self {
            omega: 0.0,
            cem43_min: 0.0,
            rates: Rates::at(t),
        }
    }

    /// Adds `seconds` in which the skin relaxes to `t` degrees C. A relaxing temperature is convex in time
    /// and so are the rates, so that the trapezium lies above.
    pub(super) fn relax(&mut self, t: f64, seconds: f64) {
        let after = Rates::at(t);
        self.omega += (self.rates.omega + after.omega) / 2.0 * seconds;
        self.cem43_min += (self.rates.cem43_min + after.cem43_min) / 2.0 * seconds;
        self.rates = after;
    }

    /// Adds `seconds` of a burst that ends with skin at `t` degrees C: all of it at the hotter end.
    pub(super) fn heat(&mut self, t: f64, seconds: f64) {
        let after = Rates::at(t);
        self.omega += self.rates.omega.max(after.omega) * seconds;
        self.cem43_min += self.rates.cem43_min.max(after.cem43_min) * seconds;
        self.rates = after;
    }

    /// Whether more than `least` is left of both doses: [`Self::ceiling_c`] takes two logarithms to tell.
    pub(super) fn leaves(&self, limits: &DoseLimits, least: &DoseLimits) -> bool {
        limits.omega - self.omega > least.omega
            && limits.cem43_min - self.cem43_min > least.cem43_min
    }

    /// The temperature, degrees C, at which what is left of both doses lasts for [`HORIZON_S`]; far below
    /// any skin when nothing is left.
    pub(super) fn ceiling_c(&self, limits: &DoseLimits) -> f64 {
        let rate = |left: f64| left.max(f64::MIN_POSITIVE) / HORIZON_S;
        let omega = rate(limits.omega - self.omega);
        let by_omega =
            HENRIQUES_EA / (GAS_CONSTANT * (LN_HENRIQUES_A - libm::log(omega))) - ZERO_CELSIUS_K;
        let doublings = libm::log2(60.0 * rate(limits.cem43_min - self.cem43_min));
        let by_cem43 = 43.0 + doublings.max(doublings / 2.0);
        by_omega.min(by_cem43)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const HARD: DoseLimits = DoseLimits {
        omega: 0.01,
        cem43_min: 2.0,
    };

    fn close(a: f64, b: f64) {
        assert!((a - b).abs() <= 1e-9 * b.abs(), "{a} is not {b}");
    }

    #[test]
    fn the_logarithm_is_that_of_the_constant() {
        assert_eq!(LN_HENRIQUES_A.to_bits(), libm::log(HENRIQUES_A).to_bits());
    }

    #[test]
    fn two_minutes_at_43_c_are_two_minutes() {
        let mut dose = Dose::new(43.0);
        dose.relax(43.0, 60.0);
        dose.heat(43.0, 60.0);
        close(dose.cem43_min, 2.0);
        // Henriques at 43 C: 3.1e98 exp(-6.27e5 / (R 316.15 K)) = 7.939e-6 1/s.
        assert!((dose.omega / 120.0 - 7.939e-6).abs() < 5e-9);
    }

    #[test]
    fn a_degree_halves_above_43_c_and_quarters_below() {
        let rate = |t: f64| Rates::at(t).cem43_min * 60.0;
        close(rate(44.0), 2.0);
        close(rate(43.0), 1.0);
        close(rate(42.0), 0.25);
        close(rate(33.0), libm::exp2(-20.0));
    }

    #[test]
    fn relaxing_counts_the_mean_of_its_ends_and_a_burst_its_hotter_one() {
        let mut dose = Dose::new(44.0);
        dose.relax(42.0, 60.0);
        close(dose.cem43_min, (2.0 + 0.25) / 2.0);
        let mean = (Rates::at(44.0).omega + Rates::at(42.0).omega) / 2.0;
        close(dose.omega, 60.0 * mean);
        let before = dose.clone();
        dose.heat(43.0, 30.0);
        close(dose.cem43_min - before.cem43_min, 0.5);
        close(dose.omega - before.omega, 30.0 * Rates::at(43.0).omega);
        let before = dose.clone();
        dose.heat(41.0, 30.0);
        close(dose.cem43_min - before.cem43_min, 0.5);
        close(dose.omega - before.omega, 30.0 * Rates::at(43.0).omega);
    }

    #[test]
    fn ample_dose_lasts_a_minute_at_that_temperature() {
        let ample = DoseLimits::ample(43_000);
        close(ample.cem43_min, 1.001);
        close(ample.omega, 60.06 * Rates::at(43.0).omega);
    }

    #[test]
    fn dose_is_left_while_more_than_that_of_both_is() {
        let mut dose = Dose::new(33.0);
        let both = |omega, cem43_min| DoseLimits { omega, cem43_min };
        for (omega, cem43_min, more) in [
            (0.0, 0.0, true),
            (6.0, 1.0, false),
            (5.999, 1.499, true),
            (0.0, 1.5, false),
            (9.0, 0.0, false),
            (6.5, 1.6, false),
        ] {
            (dose.omega, dose.cem43_min) = (omega, cem43_min);
            let leaves = dose.leaves(&both(8.0, 2.0), &both(2.0, 0.5));
            assert_eq!(leaves, more, "{omega} {cem43_min}");
        }
    }

    #[test]
    fn the_ceiling_spends_what_is_left_within_a_minute() {
        let mut dose = Dose::new(33.0);
        // Two minutes at 44 C are two a minute.
        close(dose.ceiling_c(&HARD), 44.0);
        for (spent, ceiling) in [
            (1.0, 43.0),
            (1.5, 42.5),
            (1.75, 42.0),
            (2.0 - 0.015625, 40.0),
        ] {
            dose.cem43_min = spent;
            close(dose.ceiling_c(&HARD), ceiling);
        }
        dose.cem43_min = 2.0;
        assert!(dose.ceiling_c(&HARD) < 0.0);
        dose.cem43_min = 0.0;
        for left in [1e-3, 1e-4, 1e-5] {
            dose.omega = 0.01 - left;
            let rate = Rates::at(dose.ceiling_c(&HARD)).omega;
            assert!((rate * HORIZON_S / left - 1.0).abs() < 1e-6);
        }
        dose.omega = 0.02;
        assert!(dose.ceiling_c(&HARD) < 0.0);
    }
}
