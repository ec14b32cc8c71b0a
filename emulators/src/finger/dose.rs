//! Burn integrals of the skin at 0.1 mm: Henriques' Omega and CEM43.
//!
//! Engineering measures, not a certificate. Henriques' constants are optimistic under 50 C, and CEM43 is
//! useless for millisecond contacts above 60 C; the plateau limits stand beside them.

use crate::solver::Solver;
use crate::solver::exact::Exact;
use crate::time::Nanos;
use palpate_core::physics::{GAS_CONSTANT, HENRIQUES_A, HENRIQUES_EA, ZERO_CELSIUS_K};

/// Under this the rates are taken at the step's maximum instead of integrated: Omega grows by at most
/// 1.7e-7 a second then.
const COOL_C: f64 = 38.0;
/// Longest step of the quadrature; the skin's fastest time constant is 1.9 ms, its own under 10 ms.
const STEP: Nanos = Nanos::from_micros(1000);
/// Nodes and weights of Gauss and Legendre's rule of three on [0, 1].
const GAUSS: [(f64, f64); 3] = [
    (0.112_701_665_379_258_31, 5.0 / 18.0),
    (0.5, 8.0 / 18.0),
    (0.887_298_334_620_741_7, 5.0 / 18.0),
];

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
        while solver.now() < to {
            let now = solver.now();
            let left = to.since(now);
            // Look ahead over the whole stretch first: a cool one is done at once.
            if solver.peaks.shallow_c < COOL_C {
                let before = solver.clone();
                solver.advance(to);
                if solver.peaks.shallow_c < COOL_C {
                    self.omega +=
                        omega_rate(solver.skin_c().0.max(before.skin_c().0)) * left.as_secs_f64();
                    return;
                }
                *solver = before;
            }
            let span = Nanos(left.0.min(STEP.0));
            self.quadrature(solver, now, span);
        }
    }

    fn quadrature(&mut self, solver: &mut Exact, from: Nanos, span: Nanos) {
        let seconds = span.as_secs_f64();
        for (place, weight) in GAUSS {
            solver.advance(Nanos(from.0 + (span.0 as f64 * place) as u64));
            let t = solver.skin_c().0;
            self.omega += omega_rate(t) * seconds * weight;
            self.cem43_min += cem43_rate(t) * seconds * weight;
        }
        solver.advance(from + span);
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
