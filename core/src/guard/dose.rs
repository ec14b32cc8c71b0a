//! Burn integrals of the skin 0.1 mm under one wire over a session, from above: Henriques' Omega and CEM43.

use crate::physics::{GAS_CONSTANT, HENRIQUES_A, HENRIQUES_EA, LN_HENRIQUES_A, ZERO_CELSIUS_K};

/// Time in which the dose left is spent at the fastest, s. A wire near its dose limit fades with it, and it covers
/// the few seconds' worth of dose that cooling skin still adds after the last burst.
const HORIZON_S: f64 = 60.0;

/// Both doses of skin 0.1 mm deep.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Doses {
    /// Henriques' Omega.
    pub omega: f64,
    /// Cumulative equivalent minutes at 43 C.
    pub cem43_min: f64,
}

impl Doses {
    /// Dose that lasts for [`HORIZON_S`] at `mc` millidegrees C, plus a thousandth that covers rounding.
    pub(super) fn ample(mc: u64) -> Self {
        let rates = Rates::at(mc as f64 * 1e-3);
        Self {
            omega: 1.001 * HORIZON_S * rates.omega,
            cem43_min: 1.001 * HORIZON_S * rates.cem43_min,
        }
    }

    /// The larger dose of each kind.
    #[must_use]
    pub const fn max(self, other: Self) -> Self {
        Self {
            omega: self.omega.max(other.omega),
            cem43_min: self.cem43_min.max(other.cem43_min),
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

/// Dose per second.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Rates {
    omega: f64,
    cem43_min: f64,
}

impl Rates {
    /// Rates at `t` degrees C. Below 39 C, where CEM43 is zero, the law is continued from above: it is convex then,
    /// and a millionth a minute at rest.
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
    /// No dose so far, with skin at `t` degrees C.
    pub(super) fn new(t: f64) -> Self {
        Self::at(Doses::default(), t)
    }

    /// A dose of `doses` so far, with skin at `t` degrees C.
    pub(super) fn at(doses: Doses, t: f64) -> Self {
        Self {
            omega: doses.omega,
            cem43_min: doses.cem43_min,
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

    /// Dose that lasts for [`HORIZON_S`] at the present temperature. A burst that ends with less left is too warm.
    pub(super) const fn kept_back(&self) -> Doses {
        Doses {
            omega: HORIZON_S * self.rates.omega,
            cem43_min: HORIZON_S * self.rates.cem43_min,
        }
    }

    /// Returns true if more than `least` is left of both doses. The comparison saves the two logarithms of
    /// [`Self::ceiling_c`].
    pub(super) fn leaves(&self, limits: &Doses, least: &Doses) -> bool {
        limits.omega - self.omega > least.omega
            && limits.cem43_min - self.cem43_min > least.cem43_min
    }

    /// The temperature, degrees C, at which the rest of both doses lasts for [`HORIZON_S`]; far below any skin when
    /// nothing is left.
    pub(super) fn ceiling_c(&self, limits: &Doses) -> f64 {
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
#[path = "dose_tests.rs"]
mod tests;
