//! Sums over the nodes in four lanes, in one order on every machine.

use crate::display::finger::NODES;
use palpate_core::vector::Simd;

/// Sum of products in four interleaved lanes: one fixed order on every machine, and short chains of additions.
#[inline(always)]
pub fn dot<S: Simd>(simd: S, a: &[f64; NODES], b: &[f64; NODES]) -> f64 {
    lanes(
        simd,
        (a, b),
        #[inline(always)]
        |a, b| simd.mul_f64s(a, b),
        #[inline(always)]
        |a, b| a * b,
    )
}

/// Length of the vectors that are taken by hand.
const QUARTER: usize = 4;

/// Sum over every pair of what `wide` or `one` makes of it, vector by vector. Compilers left to themselves take such
/// a sum apart when much else stands around it.
#[inline(always)]
pub fn lanes<S: Simd>(
    simd: S,
    (a, b): (&[f64; NODES], &[f64; NODES]),
    wide: impl Fn(S::f64s, S::f64s) -> S::f64s,
    one: impl Fn(f64, f64) -> f64,
) -> f64 {
    let mut lane = [0.0; QUARTER];
    let (x, y) = (S::as_simd_f64s(a).0, S::as_simd_f64s(b).0);
    if S::F64_LANES == QUARTER
        && let ([x0, x1, x2, x3], [y0, y1, y2, y3]) = (x, y)
    {
        let even = simd.add_f64s(wide(*x0, *y0), wide(*x2, *y2));
        let odd = simd.add_f64s(wide(*x1, *y1), wide(*x3, *y3));
        S::as_mut_simd_f64s(&mut lane).0[0] = simd.add_f64s(even, odd);
    } else {
        for l in 0..QUARTER {
            let at = |vector: usize| one(a[vector * QUARTER + l], b[vector * QUARTER + l]);
            lane[l] = (at(0) + at(2)) + (at(1) + at(3));
        }
    }
    (lane[0] + lane[1]) + (lane[2] + lane[3]) + one(a[NODES - 1], b[NODES - 1])
}
