//! Tests of `perceiver.rs`.

use super::*;

#[test]
fn the_phantom_is_where_the_energy_is() {
    let p = Perceiver::new(PerceiverParameters {
        fitted_gain: 21.6,
        threshold_um: 1.0,
        expansion: 11e-6,
        full_pulses: 7,
    });
    let wire = WireParameters::FINAL;
    let full = p.amplitude_of_pulses(&wire, 0.602 * 0.914e-3, 7);
    assert!((full - 10.0).abs() < 0.1, "{full}");
    assert!(!p.detects(p.amplitude_of_pulses(&wire, 0.09 * 0.602 * 0.914e-3, 7)));
    assert!(p.detects(p.amplitude_of_pulses(&wire, 0.11 * 0.602 * 0.914e-3, 7)));
    let at = |x: f64, amplitude_um: f64| Vibration {
        position_mm: (x, 1.0),
        amplitude_um,
    };
    assert_eq!(p.feel(&[at(0.0, 0.5), at(3.0, 0.9)]), None);
    let felt = p
        .feel(&[at(0.0, 10.0), at(5.0, 5.0), at(100.0, 0.9)])
        .unwrap();
    assert_eq!(felt.wires, 2);
    assert!((felt.place(Centroid::Energy).0 - 1.0).abs() < 1e-12);
    assert!((felt.place(Centroid::Amplitude).0 - 5.0 / 3.0).abs() < 1e-12);
}
