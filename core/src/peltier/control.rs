//! PI control in terms of heat: what the face shall gain in a second becomes a current by the module's own equation.

use crate::physics::PeltierParameters;

use super::guard::{Seen, current};

/// Heat per error, 1/s: how fast an error would vanish. Half of what a lag of 60 ms behind the estimate bears.
const GAIN_S: f64 = 2.0;
/// The integral takes over what a constant error asks for in this time, s.
const INTEGRAL_S: f64 = 2.0;
/// Most that the integral may hold, W: what skin and a sink at its limit bring.
const MOST_W: f64 = 1.5;

/// A PI controller of heat, with the ramp fed forward.
#[derive(Clone, Debug)]
pub(super) struct Control {
    parameters: PeltierParameters,
    integral_w: f64,
    error_k: f64,
}

impl Control {
    pub(super) const fn new(parameters: PeltierParameters) -> Self {
        Self {
            parameters,
            integral_w: 0.0,
            error_k: 0.0,
        }
    }

    /// Forgets what it has learnt.
    pub(super) const fn reset(&mut self) {
        self.integral_w = 0.0;
        self.error_k = 0.0;
    }

    /// The current, A, for a face that shall be at `aim_c` and move by `ramp_k_s`.
    pub(super) fn current(&mut self, seen: &Seen, aim_c: f64, ramp_k_s: f64) -> f64 {
        self.error_k = aim_c - seen.face_c;
        let gained_w = self.parameters.face_j_k * (ramp_k_s + GAIN_S * self.error_k);
        current(&self.parameters, seen, -(gained_w + self.integral_w))
    }

    /// Integrates the error of the last turn, but not beyond a current that was refused.
    pub(super) fn learn(&mut self, asked: f64, given: f64, seconds: f64) {
        // Less current means more heat, so what was held back on one side is learnt on the other alone.
        let further = (given - asked) * self.error_k;
        if (given - asked).abs() < 2e-3 || further < 0.0 {
            let step = self.parameters.face_j_k * GAIN_S / INTEGRAL_S * self.error_k * seconds;
            self.integral_w = (self.integral_w + step).clamp(-MOST_W, MOST_W);
        }
    }
}
