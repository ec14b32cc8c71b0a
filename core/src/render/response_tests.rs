//! Tests of `response.rs`.

use super::*;

#[test]
fn a_width_is_found_from_its_amplitude_and_back() {
    let response = Response::linear(Ticks::new(40));
    for width in 0..=40 {
        assert_eq!(response.width(f32::from(width)), Ticks::new(width));
        assert!((response.amplitude(f32::from(width)) - f32::from(width)).abs() < 1e-6);
    }
    assert_eq!(response.width(7.4), Ticks::new(7));
    assert_eq!(response.width(7.6), Ticks::new(8));
    assert_eq!(response.width(1e9), Ticks::new(40));
    assert_eq!(response.width(f32::NAN), Ticks::ZERO);
    assert!((response.amplitude(7.25) - 7.25).abs() < 1e-6);
    assert!((response.amplitude(1e9) - 40.0).abs() < 1e-6);
}

#[test]
fn a_wider_pulse_that_is_felt_less_counts_as_the_narrower() {
    let response = Response::new([0.0, 2.0, 1.0, 3.0].into());
    assert_eq!(response.width(2.0), Ticks::new(1));
    assert!((response.amplitude(2.0) - 2.0).abs() < 1e-6);
    assert!((response.largest() - 3.0).abs() < 1e-6);
}

#[test]
fn between_known_widths_amplitudes_are_straight() {
    let response = Response::between(&[(0, 0.0), (2, 1.0), (4, 5.0)]);
    assert_eq!(response, Response::new([0.0, 0.5, 1.0, 3.0, 5.0].into()));
    let narrow = Response::thin_8mm(Ticks::new(13));
    assert!((narrow.largest() - 0.041_054_68).abs() < 1e-9);
    let whole = Response::thin_8mm(Ticks::new(49));
    assert_eq!(whole.width(whole.largest()), Ticks::new(41));
}
