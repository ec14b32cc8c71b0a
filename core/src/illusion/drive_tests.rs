//! Tests of `drive.rs`.

use super::*;

const DRIVE: Drive = Drive {
    alpha: 0.01,
    beta: 0.0244,
    floor: 0.5,
    steps: Steps::Even,
};

#[test]
fn nothing_active_means_off_even_with_an_offset() {
    assert_eq!(DRIVE.width(0.0), Ticks::ZERO);
    assert_eq!(DRIVE.width(1.0), Ticks::from_duty(0.0344));
    assert_eq!(DRIVE.width(f32::NAN), Ticks::ZERO);
    assert_eq!(DRIVE.weight(1, 10), 0.5);
    assert_eq!(DRIVE.weight(10, 10), 1.0);
    assert_eq!(DRIVE.weight(1, 1), 1.0);
}

#[test]
fn weber_levels_differ_by_the_fraction_down_to_the_floor() {
    let drive = Drive {
        steps: Steps::Weber(0.2),
        ..DRIVE
    };
    assert_eq!(drive.weight(10, 10), 1.0);
    assert!((drive.weight(10, 10) / drive.weight(9, 10) - 1.2).abs() < 1e-5);
    assert_eq!(drive.weight(1, 10), 0.5);
}

#[test]
fn a_calibration_keeps_silence_and_full_scale() {
    let person = Calibration::new(&[1.0, 0.8], &[0.25, 0.0]).unwrap();
    assert_eq!(person.apply(0, 0.0), 0.0);
    assert_eq!(person.apply(0, 1.0), 1.0);
    assert_eq!(person.apply(0, 0.5), 0.625);
    assert_eq!(person.apply(1, 1.0), 0.8);
    assert_eq!(person.apply(2, 1.0), 0.0);
    assert_eq!(Calibration::even(1).apply(0, 0.3), 0.3);
}

#[test]
fn a_calibration_beyond_full_scale_is_refused_by_wire() {
    let refused = |gain: f32, threshold: f32| Calibration::new(&[1.0, gain], &[0.0, threshold]);
    for gain in [0.0, -1.0, 1.01, f32::NAN] {
        assert_eq!(refused(gain, 0.0), Err(CalibrationError::Gain(1)));
    }
    for threshold in [1.0, 2.0, -0.1, f32::NAN] {
        assert_eq!(refused(1.0, threshold), Err(CalibrationError::Threshold(1)));
    }
    assert_eq!(Calibration::new(&[1.0], &[]), Err(CalibrationError::Count));
}
