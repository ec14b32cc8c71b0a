//! Tests of half precision.

use super::*;

/// The number of some bits by the standard's formula, in double precision.
fn by_formula(bits: u16) -> f64 {
    let (exponent, fraction) = (i32::from(bits >> 10 & 0x1F), f64::from(bits & 0x3FF));
    let size = match exponent {
        0 => fraction / 1024.0 * f64::powi(2.0, -14),
        _ => (1.0 + fraction / 1024.0) * f64::powi(2.0, exponent - 15),
    };
    if bits >> 15 == 1 { -size } else { size }
}

#[test]
fn every_number_widens_by_the_formula_and_comes_back() {
    let finite = (0..=u16::MAX).filter(|bits| bits >> 10 & 0x1F != 0x1F);
    for bits in finite {
        let wide = widen(bits);
        assert_eq!(f64::from(wide).to_bits(), by_formula(bits).to_bits());
        assert_eq!(narrow(wide), bits);
    }
    assert_eq!(widen(0x7C00).to_bits(), f32::INFINITY.to_bits());
    assert_eq!(widen(0xFC00).to_bits(), f32::NEG_INFINITY.to_bits());
    assert!(widen(0x7E00).is_nan() && widen(narrow(f32::NAN)).is_nan());
}

#[test]
fn a_number_between_two_goes_to_the_nearer_and_from_the_middle_to_the_even_one() {
    for low in 0..0x7BFF_u16 {
        let (a, b) = (widen(low), widen(low + 1));
        let middle = (a + b) / 2.0; // exact: single precision has the digits
        let even = low + (low & 1);
        assert_eq!(narrow(middle), even, "{low}");
        assert_eq!(narrow(middle.next_down()), low, "{low}");
        assert_eq!(narrow(middle.next_up()), low + 1, "{low}");
    }
    // Half a step beyond the largest is infinite, as the standard says.
    assert_eq!(narrow(65_519.0), 0x7BFF);
    assert_eq!(narrow(65_520.0), 0x7C00);
    assert_eq!(narrow(-1e9), 0xFC00);
}
