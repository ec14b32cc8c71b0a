//! Tests of `drv2605.rs`.

use super::*;

/// The example of TI's forum, a C10-100 of 2 V RMS at 175 Hz, has 0x53: rounded to the nearest, it stands for 2.001 V.
#[test]
fn a_rated_voltage_is_rounded_down() {
    let step = rated_step_lra(RESET[usize::from(CONTROL2)], 175.0);
    let code = code(2.0, step).unwrap();
    assert!((0x52..=0x53).contains(&code), "{code:#x}");
    assert!(f64::from(code) * step <= 2.0 + 1e-9);
    assert!(f64::from(code + 1) * step > 2.0);
}

#[test]
fn voltages_of_zero_and_beyond_8_bits_have_no_code() {
    assert_eq!(code(0.0, CLAMP_STEP_LRA), None);
    assert_eq!(code(-1.0, CLAMP_STEP_LRA), None);
    assert_eq!(code(f64::NAN, CLAMP_STEP_LRA), None);
    assert_eq!(code(5.5, CLAMP_STEP_LRA), None);
    assert_eq!(code(CLAMP_STEP_LRA, CLAMP_STEP_LRA), Some(1));
}

#[test]
fn half_a_period_of_175_hz_is_2_9_ms() {
    assert_eq!(drive_time_lra(175.0), 24);
    assert_eq!(drive_time_lra(1e9), 0);
    assert_eq!(drive_time_lra(1.0), 31);
}
