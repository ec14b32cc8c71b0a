//! exp(-lambda t) of all modes at once.
//!
//! A scalar `exp` is most of what an event costs. This one is the same few products and sums for every mode, in a
//! fixed order, so that compilers put it into vector registers and every machine gives the same bits.

use crate::display::finger::NODES;

/// Two parts of ln 2: the first has zeros where products with small integers need room.
const LN_2_HIGH: f64 = 6.931_471_803_691_238e-1;
const LN_2_LOW: f64 = 1.908_214_929_270_587_7e-10;
/// Number whose addition rounds to an integer, which then stands in the lowest bits.
const ROUNDER: f64 = 6_755_399_441_055_744.0; // 1.5 * 2^52
/// Exponent that stands for all further ones: far under any temperature, and over what a run reaches.
const FURTHEST: f64 = 700.0;

/// Coefficients 1/2! to 1/13! of the series of exp(r) - 1 with |r| <= ln(2) / 2: the rest is under 2e-17 of it.
const SERIES: [f64; 12] = {
    let mut out = [0.0; 12];
    let (mut k, mut value) = (0, 1.0);
    while k < 12 {
        value /= (k + 2) as f64;
        out[k] = value;
        k += 1;
    }
    out
};

/// exp(-lambda t), and 1 - exp(-lambda t) without cancellation, for every rate.
#[inline(always)]
pub fn decays(lambda: &[f64; NODES], t: f64) -> ([f64; NODES], [f64; NODES]) {
    let (mut decay, mut fallen) = ([0.0; NODES], [0.0; NODES]);
    for k in 0..NODES {
        let x = (-lambda[k] * t).clamp(-FURTHEST, FURTHEST);
        let shifted = x * core::f64::consts::LOG2_E + ROUNDER;
        let n = shifted - ROUNDER;
        let r = (x - n * LN_2_HIGH) - n * LN_2_LOW;
        // Even and odd powers apart: two short chains of operations in place of a long one.
        let square = r * r;
        let (mut even, mut odd) = (SERIES[10], SERIES[11]);
        for pair in SERIES[..10].as_chunks::<2>().0.iter().rev() {
            (even, odd) = (even * square + pair[0], odd * square + pair[1]);
        }
        let part = r + square * (even + r * odd); // exp(r) - 1
        // 2^n: the low bits of `shifted` are n, moved to where an exponent stands.
        let power = f64::from_bits((shifted.to_bits() << 52).wrapping_add(1023 << 52));
        decay[k] = power + power * part;
        fallen[k] = (1.0 - power) - power * part;
    }
    (decay, fallen)
}

#[cfg(test)]
#[allow(clippy::float_cmp)] // exact by construction
#[path = "decay_tests.rs"]
mod tests;
