//! The fused multiply-add: `a * b + c`, rounded once, on every machine.
//!
//! Vectors have an instruction for it. Numbers one by one have none in WebAssembly, nor on an x86-64 without FMA, and
//! `libm` takes ten times as long as what is done here: the product of two f32 is exact in f64.

use pulp::{Simd, bytemuck::cast};

/// Digits that an f64 has and an f32 has not, and what they are halfway between two f32.
const BELOW: u64 = (1 << 29) - 1;
const HALFWAY: u64 = 1 << 28;

/// Three vectors of f32.
#[inline(always)]
pub(super) fn fused<S: Simd>(simd: S, a: S::f32s, b: S::f32s, c: S::f32s) -> S::f32s {
    if S::IS_SCALAR {
        return cast(one(cast(a), cast(b), cast(c)));
    }
    simd.mul_add_f32s(a, b, c)
}

/// Three vectors of f64, where the product has no more digits than an f64: any two f32 are such factors.
#[inline(always)]
pub(super) fn fused_exact<S: Simd>(simd: S, a: S::f64s, b: S::f64s, c: S::f64s) -> S::f64s {
    if S::IS_SCALAR {
        return simd.add_f64s(simd.mul_f64s(a, b), c);
    }
    simd.mul_add_f64s(a, b, c)
}

/// One number. The sum is rounded to f64 and then to f32, which is one rounding too many only where the first one ends
/// halfway between two f32. Those among the subnormal numbers lie elsewhere, so all of them take the long way.
///
/// Put in place where it is all there is. A processor that mostly has vectors calls it: the encoder's unrolled loops would
/// be several times as large for machines of before 2013.
#[cfg_attr(any(target_arch = "x86", target_arch = "x86_64"), inline(never))]
#[cfg_attr(not(any(target_arch = "x86", target_arch = "x86_64")), inline(always))]
fn one(a: f32, b: f32, c: f32) -> f32 {
    let (product, c) = (f64::from(a) * f64::from(b), f64::from(c));
    let sum = product + c;
    let near = sum as f32;
    let subnormal = (near.to_bits() << 1).wrapping_sub(1) < f32::MIN_POSITIVE.to_bits() << 1;
    match sum.to_bits() & BELOW == HALFWAY || subnormal {
        true => odd(product, c),
        false => near,
    }
}

/// The sum of two numbers, rounded to odd in f64 (Boldo and Melquiond, 2008): then an f32 of it is the exact sum's.
#[cold]
#[inline(never)]
fn odd(product: f64, c: f64) -> f32 {
    let sum = product + c;
    // What rounding has taken away, exactly (Knuth).
    let of_c = sum - product;
    let rest = (product - (sum - of_c)) + (c - of_c);
    let bits = sum.to_bits();
    if rest == 0.0 || !rest.is_finite() || bits & 1 == 1 {
        return sum as f32;
    }
    // An even neighbour was chosen: the odd one lies on the side of the rest.
    let outwards = (rest < 0.0) == (sum < 0.0);
    f64::from_bits(if outwards { bits + 1 } else { bits - 1 }) as f32
}

#[cfg(test)]
#[path = "fused_tests.rs"]
mod tests;
