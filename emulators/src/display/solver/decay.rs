//! exp(-lambda t) of all modes at once, and sines beside them.
//!
//! A scalar `exp` is most of what an event costs. These are the same few products and sums for every value, in a fixed
//! order, so that compilers put them into vector registers and every machine gives the same bits.

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

/// Three parts of pi / 2: the first two have zeros where products with integers up to 2^20 need room.
const QUARTER_HIGH: f64 = 1.570_796_326_734_125_6;
const QUARTER_MIDDLE: f64 = 6.077_100_506_303_966e-11;
const QUARTER_LOW: f64 = 2.022_266_248_795_950_6e-21;
/// Largest angle, rad: what a filter rang has long died away.
const MOST_TURNED: f64 = 1e6;

/// Coefficients of r^2, r^4, ... of cos(r) - 1, beside those of sin(r) / r - 1, for |r| <= pi / 4.
const ALTERNATING: [[f64; 2]; 8] = {
    let mut out = [[0.0; 2]; 8];
    let (mut k, mut value) = (0, 1.0);
    while k < 8 {
        let even = (2 * k + 2) as f64;
        value /= -(even - 1.0) * even;
        out[k] = [value, value / (even + 1.0)];
        k += 1;
    }
    out
};

/// exp(-lambda t), and 1 - exp(-lambda t) without cancellation, for every rate.
#[inline(always)]
pub fn decays(lambda: &[f64; NODES], t: f64) -> ([f64; NODES], [f64; NODES]) {
    exponentials(&lambda.map(
        #[inline(always)]
        |rate| -rate * t,
    ))
}

/// exp(x), and 1 - exp(x) without cancellation, for every value up to [`FURTHEST`].
#[inline(always)]
pub fn exponentials<const N: usize>(values: &[f64; N]) -> ([f64; N], [f64; N]) {
    let (mut decay, mut fallen) = ([0.0; N], [0.0; N]);
    for k in 0..N {
        let x = values[k].clamp(-FURTHEST, FURTHEST);
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

/// Sine and cosine of every angle, rad: to a unit of the last place up to [`MOST_TURNED`], where larger angles are put.
#[inline(always)]
pub fn turns<const N: usize>(angles: &[f64; N]) -> ([f64; N], [f64; N]) {
    let (mut sines, mut cosines) = ([0.0; N], [0.0; N]);
    for k in 0..N {
        let x = angles[k].clamp(-MOST_TURNED, MOST_TURNED);
        let shifted = x * core::f64::consts::FRAC_2_PI + ROUNDER;
        let n = shifted - ROUNDER;
        let r = ((x - n * QUARTER_HIGH) - n * QUARTER_MIDDLE) - n * QUARTER_LOW;
        let square = r * r;
        let (mut odd, mut even) = (0.0, 0.0);
        for term in (0..ALTERNATING.len()).rev() {
            (odd, even) = (
                odd * square + ALTERNATING[term][1],
                even * square + ALTERNATING[term][0],
            );
        }
        let (sine, cosine) = (r + r * square * odd, 1.0 + square * even);
        // The low bits of `shifted` are the number of quarter turns.
        let quarters = shifted.to_bits();
        let (a, b) = match quarters & 1 == 0 {
            true => (sine, cosine),
            false => (cosine, sine),
        };
        sines[k] = f64::from_bits(a.to_bits() ^ ((quarters & 2) << 62));
        cosines[k] = f64::from_bits(b.to_bits() ^ ((quarters.wrapping_add(1) & 2) << 62));
    }
    (sines, cosines)
}

#[cfg(test)]
#[allow(clippy::float_cmp)] // exact by construction
#[path = "decay_tests.rs"]
mod tests;
