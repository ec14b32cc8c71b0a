//! The maximum of a sum of exponentials over a span: branch and bound.
//!
//! A piece of the span is left as soon as its ceiling is no higher than the known maximum. The rest is halved, in the
//! logarithm of time, until it bends one way only and Newton finds its turn. The heat of a pulse arrives after the
//! pulse, so a tissue may cool at both ends of a span and have a peak between: the ends alone tell nothing.

use super::lanes::{dot, lanes};
use super::sum::{Sum, SumPoint, signs};
use crate::display::finger::NODES;
use palpate_core::vector::{Scalar, Simd};

/// Excess of a ceiling that counts as none, K: far under the promised 1e-9.
pub const ENOUGH_K: f64 = 1e-11;
/// Halvings of a span after which the rest is shorter than any clock tells.
const DEEPEST: u32 = 60;

/// The maximum of `sum` between two instants of it, or `known` if that is higher.
pub fn highest(sum: &Sum<'_>, from: &SumPoint, to: &SumPoint, known: f64) -> f64 {
    within(sum, from, to, known.max(from.value).max(to.value), DEEPEST)
}

/// Bound that a sum with these decay rates cannot pass between two instants of it; refines no further than to
/// `enough`.
#[inline(always)]
pub fn ceiling_between<S: Simd>(
    simd: S,
    lambda: &[f64; NODES],
    from: &SumPoint,
    to: &SumPoint,
    enough: f64,
) -> f64 {
    let (ends, span) = ((from.value, to.value), to.t - from.t);
    let slopes = spread(simd, (from.slope, to.slope), (&from.terms, &to.terms));
    let rough = ceiling(ends, slopes, span);
    if rough <= enough {
        return rough;
    }
    if peaks(from, to) == Some(0) {
        return max(from.value, to.value);
    }
    ceiling(ends, by_parts(&from.terms, lambda[0] < 0.0, slopes), span)
}

/// Number of peaks between two instants, where the signs of the partial sums give it.
#[inline(always)]
fn peaks(from: &SumPoint, to: &SumPoint) -> Option<usize> {
    let (turns, first) = signs(&from.terms);
    match turns {
        0 => Some(0),
        // One turn: a dip or a peak, if it comes before the end.
        1 if first < 0.0 || to.slope >= 0.0 => Some(0),
        1 if from.slope > 0.0 => Some(1),
        _ => None,
    }
}

fn within(sum: &Sum<'_>, from: &SumPoint, to: &SumPoint, known: f64, depth: u32) -> f64 {
    let span = to.t - from.t;
    let enough = known + ENOUGH_K;
    let slopes = spread(Scalar, (from.slope, to.slope), (&from.terms, &to.terms));
    if ceiling((from.value, to.value), slopes, span) <= enough || depth == 0 {
        return known;
    }
    let peak = || sum.value(sum.turn_between(from.t, to.t));
    match peaks(from, to) {
        Some(0) => return known,
        Some(_) => return max(known, peak()),
        None => (),
    }
    let grows = sum.lambda[0] < 0.0;
    let slopes = by_parts(&from.terms, grows, slopes);
    if ceiling((from.value, to.value), slopes, span) <= enough {
        return known;
    }
    let bend =
        |p: &SumPoint| -> [f64; NODES] { core::array::from_fn(|k| -sum.lambda[k] * p.terms[k]) };
    let (then, there) = (bend(from), bend(to));
    let ends = (
        -dot(Scalar, sum.lambda, &from.terms),
        -dot(Scalar, sum.lambda, &to.terms),
    );
    let bends = by_parts(&then, grows, spread(Scalar, ends, (&then, &there)));
    if bends.0 >= 0.0 {
        return known; // highest at an end
    }
    if bends.1 <= 0.0 {
        let turns = from.slope > 0.0 && to.slope < 0.0;
        return if turns { max(known, peak()) } else { known };
    }
    let falling = (-from.slope, -to.slope);
    let slopes = (
        max(slopes.0, -ceiling(falling, (-bends.1, -bends.0), span)),
        min(slopes.1, ceiling((from.slope, to.slope), bends, span)),
    );
    if ceiling((from.value, to.value), slopes, span) <= enough {
        return known;
    }
    // Fast terms are gone soon: cut where both parts have the same share of decades.
    let cut = if from.t > 0.0 {
        libm::sqrt(from.t * to.t).max(from.t + span / 64.0)
    } else {
        to.t / 8.0
    };
    let middle = sum.point(cut);
    let known = max(known, middle.value);
    // The half with the peak comes first, because its maximum may settle the other.
    if middle.slope > 0.0 {
        let known = within(sum, &middle, to, known, depth - 1);
        within(sum, from, &middle, known, depth - 1)
    } else {
        let known = within(sum, from, &middle, known, depth - 1);
        within(sum, &middle, to, known, depth - 1)
    }
}

/// The least and the most that terms can have added up to between two instants, from their sums at both. Every term
/// goes one way, so the sum lies between those of the smaller and of the larger ones.
#[inline(always)]
fn spread<S: Simd>(
    simd: S,
    (a, b): (f64, f64),
    (then, there): (&[f64; NODES], &[f64; NODES]),
) -> (f64, f64) {
    // The greater of both differences in place of a magnitude: pulp's `abs` is not inlined.
    let apart = lanes(
        simd,
        (then, there),
        #[inline(always)]
        |a, b| simd.max_f64s(simd.sub_f64s(a, b), simd.sub_f64s(b, a)),
        #[inline(always)]
        |a, b| (a - b).abs(),
    );
    ((a + b - apart) / 2.0, (a + b + apart) / 2.0)
}

/// Narrows such bounds: written by parts, slowest first, the sum is a weighted mean of the partial sums and zero,
/// unless a term grows.
#[inline(always)]
fn by_parts(then: &[f64; NODES], grows: bool, (least, most): (f64, f64)) -> (f64, f64) {
    if grows {
        return (least, most);
    }
    let (mut lowest, mut highest, mut partial) = (0.0, 0.0, 0.0);
    for term in then {
        partial += term;
        highest = max(highest, partial);
        lowest = min(lowest, partial);
    }
    (max(least, lowest), min(most, highest))
}

/// Bound that a value cannot pass on its way from one to another with slopes between these.
#[inline(always)]
fn ceiling((from, to): (f64, f64), (least, most): (f64, f64), span: f64) -> f64 {
    if most <= 0.0 || least >= 0.0 {
        return max(from, to);
    }
    // The bound rises at the steepest slope, then falls at the steepest to the other end.
    let up = ((to - from) - least * span) / (most - least);
    from + most * up.clamp(0.0, span)
}

/// Larger of two numbers in one instruction, where `f64::max` takes care of NaN.
#[inline(always)]
fn max(a: f64, b: f64) -> f64 {
    if a > b { a } else { b }
}

#[inline(always)]
fn min(a: f64, b: f64) -> f64 {
    if a < b { a } else { b }
}
