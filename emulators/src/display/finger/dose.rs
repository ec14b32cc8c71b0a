//! Burn integrals of the tissue at 0.1 mm: Henriques' Omega and CEM43.
//!
//! Engineering measures, not a certificate. Henriques' constants are optimistic under 50 C, and CEM43 is
//! useless for millisecond contacts above 60 C; the plateau limits stand beside them.

use palpate_core::physics::{GAS_CONSTANT, HENRIQUES_EA, LN_HENRIQUES_A, ZERO_CELSIUS_K};

/// Longest first step of the quadrature after an edge, s: a PWM period and its ripple are one.
const STEP_S: f64 = 6e-3;
/// Steps shorter than this have no middle point, s.
const SHORT_S: f64 = 0.5e-3;

/// Dose since it was switched on.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Dose {
    /// Henriques' Omega, 1; 0.53 is a first-degree burn.
    pub omega: f64,
    /// Cumulative equivalent minutes at 43 C.
    pub cem43_min: f64,
    /// Integral of the temperature, degrees C times seconds: the difference of two over the time between is a
    /// mean.
    pub celsius_s: f64,
}

impl Dose {
    /// Adds a stretch of `span` seconds in which the temperature (degrees C) goes from `first` to `last` by way
    /// of `between`.
    pub(crate) fn add(&mut self, span: f64, first: f64, last: f64, between: impl Fn(f64) -> f64) {
        let rate = |t: f64| (omega_rate(t), cem43_rate(t));
        let (mut at, mut step, mut before) = (0.0, STEP_S, rate(first));
        while at < span {
            let end = if at + step * 1.5 < span {
                at + step
            } else {
                span
            };
            let after = if end < span {
                rate(between(end))
            } else {
                rate(last)
            };
            let middle = (end - at >= SHORT_S).then(|| rate(between((at + end) / 2.0)));
            let mean = |a: f64, m: Option<f64>, b: f64| match m {
                Some(m) => (a + 4.0 * m + b) / 6.0,
                None => (a + b) / 2.0,
            };
            self.omega += mean(before.0, middle.map(|m| m.0), after.0) * (end - at);
            self.cem43_min += mean(before.1, middle.map(|m| m.1), after.1) * (end - at);
            (at, before) = (end, after);
            // Undisturbed tissue only relaxes, ever more slowly.
            step *= 1.25;
        }
    }
}

/// Rate of Henriques' integral at `t` degrees C, 1/s.
pub(crate) fn omega_rate(t: f64) -> f64 {
    let exponent = HENRIQUES_EA / (GAS_CONSTANT * (t + ZERO_CELSIUS_K));
    libm::exp(LN_HENRIQUES_A - exponent)
}

/// Equivalent minutes at 43 C per second at `t` degrees C.
pub(crate) fn cem43_rate(t: f64) -> f64 {
    let per_minute = if t >= 43.0 {
        libm::exp2(t - 43.0)
    } else if t >= 39.0 {
        libm::exp2(-2.0 * (43.0 - t))
    } else {
        0.0
    };
    per_minute / 60.0
}
