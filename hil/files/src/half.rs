//! Numbers of half precision (binary16 of IEEE 754), in which a model file may hold its weights.

/// Bits of half precision's fraction that single precision has more.
const MORE: u32 = 13;
/// Distance of both exponents' zeros.
const SHIFT: u32 = 112;

/// The number of these bits, exactly.
pub fn widen(bits: u16) -> f32 {
    let sign = u32::from(bits >> 15) << 31;
    let (exponent, fraction) = (u32::from(bits >> 10 & 0x1F), u32::from(bits & 0x3FF));
    let size = match exponent {
        // Steps of 2^-24 below the smallest of full precision.
        0 => (fraction as f32 * f32::from_bits((127 - 24) << 23)).to_bits(),
        0x1F => 0xFF << 23 | fraction << MORE,
        _ => (exponent + SHIFT) << 23 | fraction << MORE,
    };
    f32::from_bits(sign | size)
}

/// The bits of the nearest number of half precision; of two equally near, the even one.
pub fn narrow(value: f32) -> u16 {
    let sign = (value.to_bits() >> 16) as u16 & 0x8000;
    let size = value.abs();
    let bits = if size.is_nan() {
        0x7E00
    } else if size < f32::from_bits((127 - 14) << 23) {
        // The last digit of a sum with a half is a step of 2^-24.
        (size + 0.5).to_bits() - 0.5_f32.to_bits()
    } else {
        let even = size.to_bits() >> MORE & 1;
        let rounded = (size.to_bits() + (1 << (MORE - 1)) - 1 + even) >> MORE;
        (rounded - (SHIFT << 10)).min(0x7C00)
    };
    sign | bits as u16
}

#[cfg(test)]
#[path = "half_tests.rs"]
mod tests;
