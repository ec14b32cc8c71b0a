//! Exponentials side by side against one at a time.

use super::*;

#[test]
fn as_good_as_one_at_a_time() {
    let mut worst = (0.0_f64, 0.0_f64);
    for i in 0..20_000 {
        // Rates over twenty decades, both signs: runaway grows.
        let x = libm::exp2(f64::from(i) * 0.0015 - 21.0) * if i % 7 == 0 { -1.0 } else { 1.0 };
        let (decay, fallen) = decays(&[x; NODES], 1.0);
        let (d, f) = (libm::exp(-x), -libm::expm1(-x));
        if d > 1e-290 && d < 1e290 {
            worst.0 = worst.0.max((decay[0] / d - 1.0).abs());
            worst.1 = worst.1.max((fallen[0] / f - 1.0).abs());
        }
    }
    println!("{:.1e} {:.1e}", worst.0, worst.1);
    assert!(worst.0 < 5e-16 && worst.1 < 5e-16, "{worst:?}");
}

#[test]
fn ends_are_ends() {
    let lambda = [
        1e-9,
        0.0,
        -1.0,
        1e300,
        f64::MAX,
        5e-324,
        1.0,
        1.0,
        1.0,
        1.0,
        1.0,
        1.0,
        1.0,
        1.0,
        1.0,
        1.0,
        1.0,
    ];
    let (decay, fallen) = decays(&lambda, 0.0);
    assert!(decay.iter().all(|d| *d == 1.0) && fallen.iter().all(|f| *f == 0.0));
    let (decay, fallen) = decays(&lambda, 1e12);
    assert!(decay.iter().chain(&fallen).all(|v| v.is_finite()));
    assert!(decay[4] < 1e-300 && fallen[4] == 1.0);
}

#[test]
fn turns_are_as_good_as_one_at_a_time() {
    let mut worst = 0.0_f64;
    for i in 0..200_000 {
        let angle = match i % 4 {
            0 => f64::from(i) * 1e-5,
            1 => f64::from(i) * -0.037,
            2 => f64::from(i) * core::f64::consts::FRAC_PI_4,
            _ => f64::from(i) * 5.0,
        };
        let ([sine], [cosine]) = turns(&[angle]);
        let (s, c) = libm::sincos(angle);
        worst = worst.max((sine - s).abs()).max((cosine - c).abs());
    }
    println!("{worst:.1e}");
    assert!(worst < 3e-16, "{worst}");
}

#[test]
fn turns_have_no_wrong_angle() {
    let (sines, cosines) = turns(&[0.0, 1e300, -f64::INFINITY, 5e-324]);
    assert_eq!((sines[0], cosines[0]), (0.0, 1.0));
    for (s, c) in sines.iter().zip(&cosines) {
        assert!((s * s + c * c - 1.0).abs() < 1e-15);
    }
    let ([sine], [cosine]) = turns(&[f64::NAN]);
    assert!(sine.is_nan() && cosine.is_nan());
}
