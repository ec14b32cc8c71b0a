//! Tests of the emulated module, alone and under the regulator.

use super::*;
use palpate_core::peltier::{PERIOD, Regulator, Wanted};
use proptest::prelude::*;

fn module() -> Peltier {
    Peltier::new(PeltierParameters::default(), Thermistor::default(), 25.0)
}

fn close(found: f64, expected: f64, part: f64) {
    assert!(
        (found - expected).abs() <= part * expected.abs(),
        "{found}, expected {expected}"
    );
}

#[test]
fn the_module_pumps_what_the_equations_say() {
    let p = PeltierParameters::default();
    for (amps, pumped, sunk) in [
        (0.5, 1.093, 1.216),
        (1.0, 1.944, 2.457),
        (-1.0, -2.263, -1.709),
    ] {
        let face_w = pumped_w(&p, 33.0, 30.0, amps);
        close(face_w, pumped, 1e-3);
        close(face_w + electrical_w(&p, 33.0, 30.0, amps), sunk, 1e-3);
    }
}

/// Sets a current without a guard.
fn flowing(milliamps: i32) -> Peltier {
    let mut module = module();
    module.bridge = Bridge::flowing(milliamps);
    module
}

#[test]
fn the_face_ramps_on_skin_as_computed() {
    for (milliamps, k_s) in [(-500, 1.9), (-1000, 4.7), (500, -2.9), (1000, -4.8)] {
        let mut module = flowing(milliamps);
        module.advance(Nanos::from_micros(100_000));
        close((module.state().face_c - 33.0) / 0.1, k_s, 0.025);
    }
}

#[test]
fn an_uncontrolled_face_is_hot_in_five_seconds_where_no_thermostat_cuts() {
    let mut module = flowing(-1000);
    for ms in 0..5000 {
        module.is_cut = false;
        module.advance(Nanos::from_micros(1000 * ms));
    }
    close(module.state().face_c, 49.0, 0.01);
    let mut module = flowing(-1000);
    module.advance(Nanos::from_micros(5_000_000));
    assert!(module.is_cut() && module.state().milliamps == 0);
    assert!(module.peaks().face_c[1] < LIMITS.thermostat_c + 0.01);
}

#[test]
fn a_step_is_as_exact_as_its_rule() {
    // A thermistor alone lags behind a face that stands, which has an exact solution.
    let mut module = module();
    module.parameters.sink_j_k = 1e6;
    module.parameters.conductance_w_k = 0.0;
    module.nodes = [33.0, 25.0, 43.0, 25.0];
    module.advance(Nanos::from_micros(300_000));
    let expected = 33.0 + 10.0 * libm::exp(-1.0);
    assert!((module.nodes[2] - expected).abs() < 1e-9);
}

#[test]
fn a_bridge_that_hears_nothing_lets_go() {
    let mut bridge = Bridge::flowing(300);
    bridge.until_ms(100);
    assert_eq!(bridge.milliamps(Nanos::from_micros(99_999)), 300);
    assert_eq!(bridge.milliamps(Nanos::from_micros(100_000)), 0);
}

/// The regulator on the module, a turn a period, until `length_s`; what is wanted is asked for at each.
fn regulate(module: &mut Peltier, length_s: f64, wanted: impl Fn(f64) -> Option<f64>) -> Vec<f64> {
    let mut regulator = Regulator::new(PeltierParameters::default(), Thermistor::default());
    let mut course = Vec::new();
    let mut now = Instant::ZERO;
    while seconds(now) < length_s {
        module.advance(Nanos::from(now));
        regulator.see(now, &module.reading());
        let wanted = wanted(seconds(now)).map(|face_c| Wanted {
            face_c,
            ceiling_c: f64::INFINITY,
        });
        let turned = regulator.turn(now, wanted);
        let Ok(()) = module.apply(&turned.update);
        course.push(module.state().face_c);
        now += PERIOD;
    }
    course
}

fn seconds(at: Instant) -> f64 {
    at.as_micros() as f64 * 1e-6
}

#[test]
fn the_face_reaches_what_is_wanted_and_stays() {
    for wanted in [20.0, 24.0, 30.0, 33.0, 36.0, 40.0] {
        let mut module = module();
        let course = regulate(&mut module, 15.0, |_| Some(wanted));
        let reached = course
            .iter()
            .position(|c| (c - wanted).abs() < 0.3)
            .unwrap();
        assert!(
            reached as f64 * 0.01 < 1.5 + (wanted - 33.0).abs() / 2.0,
            "{wanted}: {reached}"
        );
        let late = &course[1000..];
        let worst = late.iter().map(|c| (c - wanted).abs()).fold(0.0, f64::max);
        assert!(worst < 0.15, "{wanted}: {worst}");
        let overshoot = course
            .iter()
            .map(|c| (c - wanted) * (wanted - 33.0).signum());
        assert!(overshoot.skip(1).fold(0.0, f64::max) < 0.5, "{wanted}");
        assert!(
            module.peaks().ramp_k_s <= LIMITS.ramp_k_s,
            "{}",
            module.peaks().ramp_k_s
        );
    }
}

#[test]
fn a_long_cold_touch_warms_the_sink_to_its_limit_and_no_further() {
    let mut module = module();
    regulate(&mut module, 600.0, |_| Some(16.0));
    let peaks = module.peaks();
    assert!(
        (43.0..=LIMITS.sink_c).contains(&peaks.sink_c),
        "{}",
        peaks.sink_c
    );
    assert!(peaks.face_c[0] >= LIMITS.face_c[0]);
}

#[test]
fn every_defect_of_the_sensor_ends_the_current_within_its_time() {
    for defect in SensorFault::ALL {
        let mut module = module();
        regulate(&mut module, 2.0, |_| Some(38.0));
        assert_ne!(module.state().milliamps, 0);
        module.set_sensor(Some(defect));
        // The face's next conversion, or as long as a reading counts, and a turn.
        let mut regulator = Regulator::new(PeltierParameters::default(), Thermistor::default());
        let mut now = Instant::from_micros(2_000_000);
        while now < Instant::from_micros(2_120_000) {
            module.advance(Nanos::from(now));
            regulator.see(now, &module.reading());
            let turned = regulator.turn(
                now,
                Some(Wanted {
                    face_c: 38.0,
                    ceiling_c: 41.0,
                }),
            );
            let Ok(()) = module.apply(&turned.update);
            now += PERIOD;
        }
        assert_eq!(module.state().milliamps, 0, "{defect:?}");
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(32))]
    /// Whatever is wanted, and however it jumps: no limit is passed by the emulated module. Off is off, and a face that was warm
    /// then falls as fast as a cold sink takes its heat.
    #[test]
    fn no_limit_is_passed_whatever_is_wanted(
        wanted in prop::collection::vec(prop::option::of(-50.0..150.0_f64), 1..20),
        air_c in 10.0..38.0_f64,
    ) {
        let mut module = Peltier::new(PeltierParameters::default(), Thermistor::default(), air_c);
        let length = wanted.len() as f64 * 1.7;
        regulate(&mut module, length, |t| wanted[(t / 1.7) as usize]);
        let peaks = module.peaks();
        prop_assert!(peaks.face_c[0] >= LIMITS.face_c[0] && peaks.face_c[1] <= LIMITS.face_c[1], "{peaks:?}");
        let p = PeltierParameters::default();
        let falls_w = p.conductance_w_k * (LIMITS.face_c[1] - air_c) + p.skin_w_k * (LIMITS.face_c[1] - 33.0);
        let falls_k_s = if wanted.contains(&None) { falls_w / p.face_j_k } else { 0.0 };
        prop_assert!(peaks.ramp_k_s <= LIMITS.ramp_k_s.max(falls_k_s), "{peaks:?}");
        prop_assert!(peaks.sink_c <= LIMITS.sink_c, "{peaks:?}");
        prop_assert!(peaks.milliamps[0] <= 1000 && peaks.milliamps[1] <= 1000, "{peaks:?}");
        prop_assert!(!module.is_cut());
    }
}
