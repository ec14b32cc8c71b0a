//! Sums of exponentials: their turns, and the times at which they cross a level.
//!
//! Everything that the exact solver asks about the time between two edges is a question about `start + sum d_i (1 -
//! exp(-lambda_i t)) / lambda_i` with rising lambda. The sum is written with its first slopes d_i: the level that it
//! settles at is too far away to subtract near electrical runaway. Laguerre's rule bounds the zeros of such a sum for
//! t > 0 by the sign changes of its partial sums, slowest first. That count alone settles nearly every interval; the
//! others are bisected until the count or a bound on the derivative settles them.

use super::decay::decays;
use super::lanes::dot;
use crate::display::finger::NODES;
use palpate_core::vector::{Scalar, Vectors};

/// An instant of a sum.
#[derive(Clone, Copy, Debug)]
pub struct SumPoint {
    /// Time, s.
    pub t: f64,
    /// Value, K.
    pub value: f64,
    /// Derivative, K/s.
    pub slope: f64,
    /// Terms of the sum, slowest first.
    pub terms: [f64; NODES],
}

/// Distance past a level that counts as crossed, K: well under the promised 1e-9.
pub const LEVEL_TOLERANCE: f64 = 1e-11;
/// Change of the value below which a turn is none, K.
const NEGLIGIBLE_K: f64 = 1e-12;
/// Share of a time below which a step is the last one towards a root.
const SMALL_STEP: f64 = 1e-5;
/// Relative size under which a derivative counts as zero.
const FLAT: f64 = 1e-13;

/// The sum `start + sum d_i (1 - exp(-lambda_i t)) / lambda_i`.
#[derive(Clone, Copy, Debug)]
pub struct Sum<'a> {
    /// Decay rates, rising, 1/s; none is zero.
    pub lambda: &'a [f64; NODES],
    /// Terms of the derivative at the start, K/s.
    pub slopes: [f64; NODES],
    /// Values that the terms approach in the end, K.
    ends: [f64; NODES],
    /// Value at the start, K.
    pub start: f64,
    vectors: Vectors,
}

impl<'a> Sum<'a> {
    /// Sum of its parts: decay rates (rising, 1/s; none zero), terms of the slope (K/s) and value (K) at the start;
    /// computed with `vectors`.
    pub fn new(
        lambda: &'a [f64; NODES],
        slopes: [f64; NODES],
        start: f64,
        vectors: Vectors,
    ) -> Self {
        let mut ends = slopes;
        for (end, rate) in ends.iter_mut().zip(lambda) {
            *end /= rate;
        }
        Self {
            lambda,
            slopes,
            ends,
            start,
            vectors,
        }
    }

    /// Value at `t` seconds.
    pub fn value(&self, t: f64) -> f64 {
        self.point(t).value
    }

    /// Value and terms of the derivative at `t`.
    pub(super) fn point(&self, t: f64) -> SumPoint {
        self.vectors.run(
            #[inline(always)]
            || self.plain_point(t),
        )
    }

    #[inline(always)]
    fn plain_point(&self, t: f64) -> SumPoint {
        let (mut terms, fallen) = decays(self.lambda, t);
        for (term, slope) in terms.iter_mut().zip(&self.slopes) {
            *term *= slope;
        }
        SumPoint {
            t,
            value: self.start + dot(Scalar, &self.ends, &fallen),
            slope: dot(Scalar, &terms, &[1.0; NODES]),
            terms,
        }
    }

    /// Terms of the derivative at `t`, scaled to that time.
    fn slope_terms(&self, t: f64) -> [f64; NODES] {
        if t <= 0.0 {
            return self.slopes;
        }
        self.vectors.run(
            #[inline(always)]
            || self.plain_point(t).terms,
        )
    }

    /// The first time in (from, to] at which the derivative changes sign.
    pub fn next_turn(&self, from: f64, to: f64) -> Option<f64> {
        self.search(from, to, 48)
    }

    fn search(&self, from: f64, to: f64, depth: u32) -> Option<f64> {
        if to <= from {
            return None;
        }
        let start = self.slope_terms(from);
        let count = changes(&start);
        if count == 0 {
            return None;
        }
        let end = self.slope_terms(to);
        let leaves = self.leaves(&start);
        let opposite = leaves * sign(&end) < 0.0;
        if count == 1 || self.derivative_is_monotone(&start, &end) {
            let turn = opposite.then(|| self.turn((from, to), leaves));
            return turn.filter(|turn| *turn > from);
        }
        if bounded_away(&start, &end) || steepest(&start, &end) * (to - from) < NEGLIGIBLE_K {
            return None;
        }
        if depth == 0 {
            return opposite.then_some(to);
        }
        let middle = from + (to - from) / 2.0;
        self.search(from, middle, depth - 1)
            .or_else(|| self.search(middle, to, depth - 1))
    }

    /// The sign of the derivative after an instant at which its terms are these: at a turn it is that of the bend.
    fn leaves(&self, terms: &[f64; NODES]) -> f64 {
        let slope = sign(terms);
        if slope != 0.0 {
            return slope;
        }
        let mut bends = *terms;
        for (bend, rate) in bends.iter_mut().zip(self.lambda) {
            *bend *= -rate;
        }
        sign(&bends)
    }

    /// Returns true if the second derivative keeps its sign between the two ends.
    fn derivative_is_monotone(&self, start: &[f64; NODES], end: &[f64; NODES]) -> bool {
        let mut s = *start;
        let mut e = *end;
        for i in 0..NODES {
            s[i] *= self.lambda[i];
            e[i] *= self.lambda[i];
        }
        bounded_away(&s, &e)
    }

    /// Value at `t` and the first three derivatives.
    fn derivatives(&self, t: f64) -> [f64; 4] {
        self.vectors.run(
            #[inline(always)]
            || {
                let point = self.plain_point(t);
                let mut bends = point.terms;
                for (bend, rate) in bends.iter_mut().zip(self.lambda) {
                    *bend *= -rate;
                }
                let bend = dot(Scalar, &bends, &[1.0; NODES]);
                let third = -dot(Scalar, self.lambda, &bends);
                [point.value, point.slope, bend, third]
            },
        )
    }

    /// The turn between two times at which the derivative has opposite signs.
    pub fn turn_between(&self, from: f64, to: f64) -> f64 {
        self.turn((from, to), self.derivatives(from)[1])
    }

    /// The turn between two times where the derivative `leaves` the first one with this sign, whatever rounding makes
    /// of it there.
    fn turn(&self, (from, to): (f64, f64), leaves: f64) -> f64 {
        let slope = |t: f64| {
            let [_, slope, bend, third] = self.derivatives(t);
            [slope, bend, third]
        };
        let mut start = slope(from);
        if start[0] * leaves <= 0.0 {
            start[0] = leaves * f64::MIN_POSITIVE;
        }
        root((from, to), start, leaves < 0.0, slope)
    }

    /// The time in [from, to] at which the sum, monotone there, rises or falls past `level`.
    pub fn crossing(&self, level: f64, from: f64, to: f64, rises: bool) -> f64 {
        let over = |t: f64| {
            let [value, slope, bend, _] = self.derivatives(t);
            [value - level, slope, bend]
        };
        let start = if from > 0.0 {
            over(from)
        } else {
            let (slope, bend) = (
                self.slopes.iter().sum(),
                -dot(Scalar, self.lambda, &self.slopes),
            );
            [self.start - level, slope, bend]
        };
        root((from, to), start, rises, over)
    }
}

/// Root of a function that `rises` or falls through zero between two times, given with two derivatives (at the
/// earlier one too). It takes Halley's steps inside a shrinking bracket. The bracket is halved instead where a step
/// would leave it, or where the last step has not halved the function.
fn root(
    (mut low, mut high): (f64, f64),
    start: [f64; 3],
    rises: bool,
    f: impl Fn(f64) -> [f64; 3],
) -> f64 {
    let sign = if rises { 1.0 } else { -1.0 };
    if start[0] * sign >= 0.0 {
        return low;
    }
    let (mut t, mut at, mut crawls) = (low, start, false);
    for _ in 0..240 {
        let [value, slope, bend] = at;
        let newton = value / slope;
        let halley = t - newton / (1.0 - newton * bend / (2.0 * slope));
        let inside = !crawls && halley > low && halley < high;
        let next = if inside {
            halley
        } else {
            low + (high - low) / 2.0
        };
        // Halley trebles the digits: after a step this small the rest is rounding. Where the function is flat but
        // bent, Halley's step is small far from the root as well; Newton's is not.
        let step = newton.abs().max((next - t).abs());
        if (inside && step <= (t * SMALL_STEP).max(1e-19)) || high - low <= high * 2e-16 {
            return next;
        }
        (t, at) = (next, f(next));
        if at[0] * sign < 0.0 {
            low = t;
        } else if at[0] * sign > 0.0 {
            high = t;
        } else {
            return t;
        }
        crawls = inside && at[0].abs() > value.abs() / 2.0;
    }
    t
}

/// Sign changes of the partial sums, rounding noise left out.
#[inline(always)]
pub(super) fn changes(b: &[f64; NODES]) -> usize {
    signs(b).0
}

/// Sign changes of the partial sums, and the last sign: that of the sum from here on, until its first zero.
#[inline(always)]
pub(super) fn signs(b: &[f64; NODES]) -> (usize, f64) {
    let (mut partials, mut noise) = ([0.0; NODES], [0.0; NODES]);
    let (mut partial, mut size) = (0.0, 0.0);
    for k in 0..NODES {
        partial += b[k];
        size += b[k].abs();
        (partials[k], noise[k]) = (partial, FLAT * size);
    }
    // Most sums have terms of one sign: one look at all of them, without a branch.
    let (mut rises, mut falls) = (false, false);
    for k in 0..NODES {
        rises |= partials[k] > noise[k];
        falls |= partials[k] < -noise[k];
    }
    match (rises, falls) {
        (true, false) => return (0, 1.0),
        (false, true) => return (0, -1.0),
        (false, false) => return (0, 0.0),
        (true, true) => (),
    }
    let (mut sign, mut count) = (0.0, 0);
    for k in 0..NODES {
        if partials[k].abs() > noise[k] {
            let s = if partials[k] > 0.0 { 1.0 } else { -1.0 };
            if sign * s < 0.0 {
                count += 1;
            }
            sign = s;
        }
    }
    (count, sign)
}

/// The sign of a sum, none within rounding noise: -1, 0 or 1.
fn sign(b: &[f64; NODES]) -> f64 {
    let sum: f64 = b.iter().sum();
    let size: f64 = b.iter().map(|v| v.abs()).sum();
    match sum.abs() <= FLAT * size {
        true => 0.0,
        false => sum.signum(),
    }
}

/// Bound on the size of the derivative between the two ends, K/s.
fn steepest(start: &[f64; NODES], end: &[f64; NODES]) -> f64 {
    let (mut top, mut bottom) = (0.0, 0.0);
    for (s, e) in start.iter().zip(end) {
        top += s.max(*e);
        bottom += s.min(*e);
    }
    f64::max(top, -bottom)
}

/// Returns true if decaying terms that begin at `start` and have become `end` cannot have summed to zero between.
fn bounded_away(start: &[f64; NODES], end: &[f64; NODES]) -> bool {
    let (mut top, mut bottom) = (0.0, 0.0);
    for (s, e) in start.iter().zip(end) {
        top += s.max(*e);
        bottom += s.min(*e);
    }
    bottom > 0.0 || top < 0.0
}
