//! Burn integrals of the skin at 0.1 mm: Henriques' Omega and CEM43.
//!
//! Engineering measures, not a certificate. Henriques' constants are optimistic under 50 C, and CEM43 is
//! useless for millisecond contacts above 60 C; the plateau limits stand beside them.

use crate::solver::Solver;
use crate::solver::exact::Exact;
use crate::time::Nanos;
use palpate_core::physics::{GAS_CONSTANT, HENRIQUES_A, HENRIQUES_EA, ZERO_CELSIUS_K};

/// Longest step of the quadrature while pulses come: a PWM period and its ripple are one.
const STEP: Nanos = Nanos::from_micros(6000);
/// Steps shorter than this have no middle point.
const SHORT: Nanos = Nanos::from_micros(500);

/// Dose since it was switched on.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Dose {
    /// Henriques' Omega, 1; 0.53 is a first-degree burn.
    pub omega: f64,
    /// Cumulative equivalent minutes at 43 C.
    pub cem43_min: f64,
}

impl Dose {
    /// Advances the solver to `to` and adds the dose on the way.
    pub(crate) fn advance(&mut self, solver: &mut Exact, to: Nanos) {
        let mut longest = STEP;
        while solver.now() < to {
            let now = solver.now();
            let span = Nanos(to.since(now).0.min(longest.0));
            self.simpson(solver, now, span);
            // Undisturbed skin only relaxes, ever more slowly.
            longest = longest + Nanos(longest.0 / 4);
        }
    }

    fn simpson(&mut self, solver: &mut Exact, from: Nanos, span: Nanos) {
        let rate = |s: &Exact| {
            let t = s.skin_c().0;
            (omega_rate(t), cem43_rate(t))
        };
        let first = rate(solver);
        let middle = (span >= SHORT).then(|| {
            solver.advance(from + Nanos(span.0 / 2));
            rate(solver)
        });
        solver.advance(from + span);
        let last = rate(solver);
        let seconds = span.as_secs_f64();
        let mean = |a: f64, m: Option<f64>, b: f64| match m {
            Some(m) => (a + 4.0 * m + b) / 6.0,
            None => (a + b) / 2.0,
        };
        self.omega += mean(first.0, middle.map(|m| m.0), last.0) * seconds;
        self.cem43_min += mean(first.1, middle.map(|m| m.1), last.1) * seconds;
    }
}

/// Rate of Henriques' integral at `t` degrees C, 1/s.
pub fn omega_rate(t: f64) -> f64 {
    let exponent = HENRIQUES_EA / (GAS_CONSTANT * (t + ZERO_CELSIUS_K));
    libm::exp(libm::log(HENRIQUES_A) - exponent)
}

/// Equivalent minutes at 43 C per second at `t` degrees C.
pub fn cem43_rate(t: f64) -> f64 {
    let per_minute = if t >= 43.0 {
        libm::exp2(t - 43.0)
    } else if t >= 39.0 {
        libm::exp2(-2.0 * (43.0 - t))
    } else {
        0.0
    };
    per_minute / 60.0
}
