//! Responses against what follows by hand, and against a run's own figures.

use super::*;

fn setup(set: &[&str]) -> Setup {
    let mut overrides = palpate_files::Overrides::default();
    for set in set {
        overrides.set("--set", set).unwrap();
    }
    let bench = palpate_files::load_bench("emulated").unwrap();
    let bench = bench.with(&overrides).unwrap();
    Setup::join(palpate_files::load_scene("idle").unwrap(), bench).unwrap()
}

/// A displacement that decays as exp(-r t) in every period has the series of a saw with that decay: its part at the n-th
/// harmonic has the amplitude 2 a (1 - e^(-r T)) / (T sqrt(r^2 + w^2)).
#[test]
fn the_part_at_a_frequency_is_that_of_a_decaying_saw() {
    let (um, rate, hz) = (3.0, 40.0, 20.0);
    let mut tone = Tone::new(hz);
    // Lifted at once: within a nanosecond.
    let jump = um * (1.0 - libm::exp(-rate / hz));
    for _ in 0..7 {
        let mut lift = Stretch::sinking(1e-9, -jump / 1e-9, 1.0);
        lift.seconds = 1e-9;
        tone.pass(&lift);
        tone.pass(&Stretch::sinking(1.0 / hz - 1e-9, um, rate));
    }
    let omega = TAU * hz;
    let expected = 2.0 * jump * hz / libm::sqrt(rate * rate + omega * omega);
    let found = tone.amplitude_um();
    assert!((found / expected - 1.0).abs() < 1e-6, "{found} {expected}");
    assert!(tone.drift_um.abs() < 1e-6, "{}", tone.drift_um);
}

#[test]
fn the_skin_moves_less_the_faster_the_pulses_come() {
    let points = frequency_response(&setup(&[]), &frequencies(10.0, 300.0, 4)).unwrap();
    assert!((points[0].hz - 10.0).abs() < 1e-9 && (points[3].hz - 300.0).abs() < 1e-9);
    for pair in points.windows(2) {
        assert!(pair[0].swing_um > pair[1].swing_um, "{pair:?}");
        assert!(pair[0].amplitude_um > pair[1].amplitude_um, "{pair:?}");
    }
    for point in &points {
        // A part is at most half of what is from end to end, or little more: a pulse train is no square wave.
        assert!(point.amplitude_um < 0.64 * point.swing_um, "{point:?}");
        let watts = 1.2 * 1.2 * 4.871;
        let spent = watts * point.width_s * point.hz;
        assert!((spent / RESPONSE_W - 1.0).abs() < 1e-3, "{point:?}");
    }
}

#[test]
fn a_current_too_weak_for_the_power_is_refused() {
    let said = frequency_response(&setup(&["bench.drive.current_ma=40"]), &[100.0]).unwrap_err();
    let said = said.to_string();
    assert!(
        said.contains("bench `emulated`: expected a frequency and a current whose pulses give 10 mW and pause, found 100 Hz and 0.008 W"),
        "{said}"
    );
    for bad in [f64::NAN, 0.0, f64::INFINITY, -1.0, 1e12] {
        assert!(frequency_response(&setup(&[]), &[bad]).is_err(), "{bad}");
        assert!(frequencies(bad, 1.0, 3).is_empty(), "{bad}");
    }
}
