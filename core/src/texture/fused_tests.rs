//! Tests of `fused.rs`, against the processor's own.

use super::*;
use proptest::prelude::*;
use pulp::Scalar;

#[track_caller]
fn same(a: f32, b: f32, c: f32) {
    let (found, expected) = (fused(Scalar, a, b, c), a.mul_add(b, c));
    let same = found.to_bits() == expected.to_bits() || found.is_nan() && expected.is_nan();
    assert!(same, "{a:e} * {b:e} + {c:e}: {found:e}, not {expected:e}");
}

/// Numbers at which roundings, signs and kinds of numbers change, and their neighbours.
fn hostile() -> impl Iterator<Item = f32> {
    let places = [
        0.0,
        f32::MIN_POSITIVE,
        f32::MAX,
        f32::INFINITY,
        f32::NAN,
        1.0,
        1.5,
        f32::EPSILON,
        16_777_216.0,
        1e-18,
        1e-23,
        3e-31,
    ];
    places.into_iter().flat_map(|at: f32| {
        let steps = (0..3).flat_map(move |n| [at.to_bits() + n, at.to_bits().saturating_sub(n)]);
        steps.flat_map(|bits| [f32::from_bits(bits), -f32::from_bits(bits)])
    })
}

#[test]
fn hostile_numbers_with_each_other() {
    for a in hostile() {
        for b in hostile() {
            for c in hostile() {
                same(a, b, c);
            }
        }
    }
}

/// Products next to half a unit of the sum, by less than an f64 of the sum can say: two roundings take them for ties.
/// In the first round the sums are ordinary numbers, in the second subnormal ones.
#[test]
fn sums_that_two_roundings_take_for_ties() {
    // 1 - 2^-46 and 1 + 2^-36.
    let [less, more] = [(23, 0.0), (12, 2f32.powi(-24))]
        .map(|(n, up)| (1.0 + 2f32.powi(-n), 1.0 - 2f32.powi(-n) + up));
    let (mut found, subnormal) = ([0, 0], f32::from_bits(1));
    for n in (1 << 18)..(1 << 18) + 999 {
        for (round, unit) in [f32::EPSILON, subnormal].into_iter().enumerate() {
            let c = [1.0 + n as f32 * unit, n as f32 * unit][round];
            // Half of the smallest number is none, and of its root there is no exact half.
            let (low, high) = [(0.5, unit), (2f32.powi(-75), 2f32.powi(-75))][round];
            for (a, b) in [less, more] {
                for (a, c) in [(a, c), (-a, c), (a, -c), (-a, -c)] {
                    same(a * low, b * high, c);
                    let twice = (f64::from(a * low) * f64::from(b * high) + f64::from(c)) as f32;
                    found[round] += u32::from(twice != (a * low).mul_add(b * high, c));
                }
            }
        }
    }
    assert!(found.iter().all(|n| *n > 1000), "{found:?}");
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(200_000))]

    #[test]
    fn any_three_numbers(a: u32, b: u32, c: u32) {
        same(f32::from_bits(a), f32::from_bits(b), f32::from_bits(c));
    }

    /// A third number in the product's reach: within 60 binary places of it.
    #[test]
    fn numbers_that_meet(a: u32, b: u32, places in -60_i32..60, digits in 1.0_f32..2.0, few in any::<bool>()) {
        // Products of few digits make ties.
        let keep = if few { 0xfff8_0000 } else { u32::MAX };
        let [a, b] = [a, b].map(|bits| f32::from_bits(bits & keep));
        let c = libm::scalbnf(a * b, places) * digits;
        same(a, b, c);
        same(a, b, -c);
    }

    /// Sums in the subnormal numbers and below.
    #[test]
    fn subnormal_sums(a: u32, b in 1_u32..0x2000, c in 0_u32..0x0100_0000, up in 0_i32..40) {
        let a = libm::scalbnf(f32::from_bits(a & 0x807f_ffff | 0x3f80_0000), up - 100);
        let b = libm::scalbnf(b as f32, -50);
        same(a, b, f32::from_bits(c));
        same(a, -b, f32::from_bits(c));
    }

    /// A product of two f32 is exact in f64, so there a sum of it is rounded once anyway.
    #[test]
    fn exact_products(a: u32, b: u32, c: f64) {
        let [a, b] = [a, b].map(|bits| f64::from(f32::from_bits(bits)));
        let (found, expected) = (fused_exact(Scalar, a, b, c), a.mul_add(b, c));
        prop_assert!(found.to_bits() == expected.to_bits() || found.is_nan() && expected.is_nan());
    }
}
