//! The two filters of a fingertip, in closed form.
//!
//! H_P(s) = s^2 w0^2 / (s^2 + w0 s + w0^2)^2 of the Pacinian channel, w0 = 2 pi 250 Hz, and
//! H_N(s) = s w1 / (s^2 + w1 s + w1^2) of the channel NP I, w1 = 2 pi 40 Hz (`docs/felt.md`).
//!
//! Both lack a gain at zero frequency, and displacement has no jumps of its own. So the *rate* of the displacement drives
//! them: where the tissue stands does not matter, and all is at rest with every state at zero.

// Indices name times, several arrays of them at once.
#![allow(clippy::needless_range_loop)]

use core::f64::consts::TAU;

use crate::display::solver::decay::{exponentials, turns};

/// Best frequency of the Pacinian channel, rad/s.
const P: f64 = TAU * 250.0;
/// Best frequency of the channel NP I, rad/s.
const N: f64 = TAU * 40.0;

/// Exponent past which nothing rings.
const SILENT: f64 = 700.0;

/// The square root of 3/4, by which both filters turn.
const ROOT: f64 = 0.866_025_403_784_438_6;

/// States of both filters: four of P, whose output is the last, then two of N, whose output is the first.
pub const STATES: usize = 6;
/// Index of the output of P among the states.
pub const OUT_P: usize = 3;
/// Index of the output of N among the states.
pub const OUT_N: usize = 4;

/// States of both filters, um.
pub type State = [f64; STATES];

/// Jump of the states where the tissue is lifted at once by 1 um.
pub const LIFT: State = [0.0, 1.0, 0.0, 0.0, 0.0, 1.0];

/// Gains of P and N for a sine of this frequency, 1.
pub fn gains(hz: f64) -> [f64; 2] {
    let band = |w: f64| {
        let x = TAU * hz / w;
        (x, (1.0 - x * x) * (1.0 - x * x) + x * x)
    };
    let ((p, p_square), (n, n_square)) = (band(P), band(N));
    [p * p / p_square, n / libm::sqrt(n_square)]
}

/// States of the forced part under a displacement whose rate is exp(-lambda t), at t = 0, s.
///
/// The poles of both filters are complex, so no real rate meets one.
pub fn forced(lambda: f64) -> State {
    let stage = |w: f64| w / (lambda * lambda - w * lambda + w * w);
    let (p, n) = (stage(P), stage(N));
    let second = P * p * p;
    [
        p,
        -lambda / P * p,
        second,
        -lambda / P * second,
        n,
        -lambda / N * n,
    ]
}

/// Effect of free motion over a time on the states.
#[derive(Clone, Copy, Debug)]
pub struct Free {
    /// The states of a stage of P from those before.
    stage: [[f64; 2]; 2],
    /// The second stage's from the first's.
    through: [[f64; 2]; 2],
    /// The states of N from those before.
    slow: [[f64; 2]; 2],
}

impl Free {
    /// Free motion that leaves nothing.
    pub const NONE: Self = Self {
        stage: [[0.0; 2]; 2],
        through: [[0.0; 2]; 2],
        slow: [[0.0; 2]; 2],
    };

    /// Free motion over each of these times, s.
    #[inline(always)]
    pub fn over<const COUNT: usize>(times: &[f64; COUNT]) -> [Self; COUNT] {
        let fast = Rings::new(P, times);
        let slow = Rings::new(N, times);
        let mut all = [Self::NONE; COUNT];
        for (i, one) in all.iter_mut().enumerate() {
            let stage = fast.matrix(i);
            // The two stages have the same poles: 1/(s^2 + s + 1)^2 and s times it.
            let (sin, cos, fall) = (fast.sin[i], fast.cos[i], fast.fall[i]);
            let theta = P * times[i];
            let half = 3.0_f64 / 4.0;
            let low = fall * (sin - ROOT * theta * cos) / (2.0 * half * ROOT);
            let band = fall * theta * sin / (2.0 * ROOT) - low / 2.0;
            *one = Self {
                stage,
                through: [[band + low, low], [stage[0][1] - low, band]],
                slow: slow.matrix(i),
            };
        }
        all
    }

    /// Outputs P and N after that time, by the state that was 1 before it.
    pub const fn outputs(&self) -> [State; 2] {
        let [a, b, c] = [&self.stage[1], &self.through[1], &self.slow[0]];
        [
            [b[0], b[1], a[0], a[1], 0.0, 0.0],
            [0.0, 0.0, 0.0, 0.0, c[0], c[1]],
        ]
    }

    /// The states after that time.
    pub fn step(&self, x: &State) -> State {
        let [a, b, c] = [&self.stage, &self.through, &self.slow];
        [
            a[0][0] * x[0] + a[0][1] * x[1],
            a[1][0] * x[0] + a[1][1] * x[1],
            b[0][0] * x[0] + b[0][1] * x[1] + a[0][0] * x[2] + a[0][1] * x[3],
            b[1][0] * x[0] + b[1][1] * x[1] + a[1][0] * x[2] + a[1][1] * x[3],
            c[0][0] * x[4] + c[0][1] * x[5],
            c[1][0] * x[4] + c[1][1] * x[5],
        ]
    }
}

/// Resonances of quality 1, each over a time of its own: exp(K theta) for K = [[0, 1], [-1, -1]].
struct Rings<const COUNT: usize> {
    sin: [f64; COUNT],
    cos: [f64; COUNT],
    /// exp(-theta / 2).
    fall: [f64; COUNT],
}

impl<const COUNT: usize> Rings<COUNT> {
    #[inline(always)]
    fn new(w: f64, times: &[f64; COUNT]) -> Self {
        let (mut angles, mut powers) = ([0.0; COUNT], [0.0; COUNT]);
        for i in 0..COUNT {
            let theta = w * times[i];
            (angles[i], powers[i]) = (ROOT * theta, -theta / 2.0);
        }
        let (sin, cos) = turns(&angles);
        let (mut fall, _) = exponentials(&powers);
        for i in 0..COUNT {
            // Nothing rings for ever: the exponential ends above 0.
            fall[i] = if powers[i] < -SILENT { 0.0 } else { fall[i] };
        }
        Self { sin, cos, fall }
    }

    #[inline(always)]
    fn matrix(&self, i: usize) -> [[f64; 2]; 2] {
        let (sin, cos, fall) = (self.sin[i], self.cos[i], self.fall[i]);
        let side = fall * sin / ROOT;
        let (sum, middle) = (side / 2.0, fall * cos);
        [[middle + sum, side], [-side, middle - sum]]
    }
}
