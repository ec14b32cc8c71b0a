//! The GRU's arithmetic on wide vectors: hyperbolic tangent, logistic function, one unit's new state.
//!
//! Only additions, fused multiply-adds, divisions, minima and maxima: the same bits in every width. Arguments are
//! finite, which the bounds of [`super::model`] ensure.

use pulp::Simd;

use super::fused::fused;

/// Beyond this tanh is 1 in f32.
const SATURATED: f32 = 9.0;
/// tanh(x) = x P(x²) / Q(x²) on [-9, 9], lowest power first: our own fit (least squares in relative error, reweighted
/// towards its maximum); 6e-8 off in exact arithmetic, 4e-7 with f32 rounding, both relative.
const P: [f32; 6] = [
    0.999_999_94,
    0.129_192_56,
    0.002_920_789,
    9.267_626e-6,
    -1.278_091e-8,
    1.825_61e-11,
];
const Q: [f32; 4] = [1.0, 0.462_525_4, 0.023_763_286, 0.000_228_103_64];

/// States smaller than this become zero: a dying state would otherwise linger among the denormal numbers, where
/// some processors take a hundred times as long. 2^-60.
const SMALLEST: f32 = 1.0 / (1u64 << 60) as f32;

#[inline(always)]
fn polynomial<S: Simd, const N: usize>(simd: S, x: S::f32s, coefficients: &[f32; N]) -> S::f32s {
    let mut sum = simd.splat_f32s(coefficients[N - 1]);
    for i in (0..N - 1).rev() {
        sum = fused(simd, sum, x, simd.splat_f32s(coefficients[i]));
    }
    sum
}

#[inline(always)]
fn within<S: Simd>(simd: S, x: S::f32s, bound: f32) -> S::f32s {
    let (low, high) = (simd.splat_f32s(-bound), simd.splat_f32s(bound));
    simd.max_f32s(simd.min_f32s(x, high), low)
}

/// tanh, at most 4e-7 off.
#[inline(always)]
pub(super) fn tanh<S: Simd>(simd: S, x: S::f32s) -> S::f32s {
    let x = within(simd, x, SATURATED);
    let square = simd.mul_f32s(x, x);
    let above = simd.mul_f32s(x, polynomial(simd, square, &P));
    let y = simd.div_f32s(above, polynomial(simd, square, &Q));
    within(simd, y, 1.0)
}

/// 1 / (1 + exp(-x)), at most 2e-7 off: the same curve as tanh.
#[inline(always)]
pub(super) fn logistic<S: Simd>(simd: S, x: S::f32s) -> S::f32s {
    let half = simd.splat_f32s(0.5);
    fused(simd, half, tanh(simd, simd.mul_f32s(half, x)), half)
}

/// The new state of units: `sums` are r, z and the input's part of n before their functions, `hidden` the state's
/// part of n with its own bias. h' = (1 - z) n + z h, n = tanh(sums n + r hidden).
#[inline(always)]
pub(super) fn unit<S: Simd>(
    simd: S,
    sums: [S::f32s; 3],
    hidden: S::f32s,
    state: S::f32s,
) -> S::f32s {
    let reset = logistic(simd, sums[0]);
    let keep = logistic(simd, sums[1]);
    let new = tanh(simd, fused(simd, reset, hidden, sums[2]));
    let next = fused(simd, keep, simd.sub_f32s(state, new), new);
    // Squares in place of magnitudes: pulp's `abs` is not inlined.
    let square = simd.mul_f32s(next, next);
    let tiny = simd.less_than_f32s(square, simd.splat_f32s(SMALLEST * SMALLEST));
    simd.select_f32s(tiny, simd.splat_f32s(0.0), next)
}

#[cfg(test)]
#[path = "gates_tests.rs"]
mod tests;
