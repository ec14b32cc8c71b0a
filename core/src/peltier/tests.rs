//! Tests of the regulator, its guard, thermistors and materials.

use super::*;
use crate::physics::ZERO_CELSIUS_K;
use proptest::prelude::*;

/// The code of a temperature, degrees C.
fn code(celsius: f64) -> u16 {
    let t = Thermistor::default();
    let kelvin = 1.0 / (celsius + ZERO_CELSIUS_K);
    let nominal = 1.0 / (Thermistor::NOMINAL_C + ZERO_CELSIUS_K);
    let ohm = t.nominal_ohm * libm::exp(t.beta_k * (kelvin - nominal));
    (f64::from(Thermistor::FULL_SCALE) * ohm / (ohm + t.series_ohm)).round() as u16
}

fn at_ms(ms: u64) -> Instant {
    Instant::from_micros(1000 * ms)
}

fn regulator() -> Regulator {
    Regulator::new(PeltierParameters::default(), Thermistor::default())
}

/// A regulator that has seen a face at rest for half a second, until `ms`.
fn settled(regulator: &mut Regulator, ms: core::ops::Range<u64>, face_c: f64, sink_c: f64) {
    for ms in ms.step_by(10) {
        let reading = Reading {
            at: at_ms(ms),
            face: code(face_c),
            sink: code(sink_c),
        };
        regulator.see(at_ms(ms), &reading);
    }
}

const WANTED: Wanted = Wanted {
    face_c: 25.0,
    ceiling_c: 41.0,
};

#[test]
fn a_code_is_a_temperature_within_a_twentieth_of_a_kelvin() {
    for celsius in [0.0, 15.0, 25.0, 33.0, 41.0, 45.0] {
        let read = thermistor::celsius(&Thermistor::default(), code(celsius)).unwrap();
        assert!((read - celsius).abs() < 0.05, "{celsius}: {read}");
    }
}

#[test]
fn a_sensor_that_is_open_shorted_or_stale_switches_off_until_it_was_good_for_a_second() {
    let faults = [
        (code(33.0), 4095, SensorFault::Open),
        (0, code(25.0), SensorFault::Short),
    ];
    for (face, sink, fault) in faults {
        let mut regulator = regulator();
        settled(&mut regulator, 0..500, 33.0, 25.0);
        assert_ne!(
            regulator.turn(at_ms(490), Some(WANTED)).update.milliamps(),
            0
        );
        let at = at_ms(500);
        regulator.see(at, &Reading { at, face, sink });
        let turned = regulator.turn(at, Some(WANTED));
        assert_eq!(turned.update.milliamps(), 0);
        assert_eq!(turned.reason, Some(PeltierReason::Sensor(fault)));
        settled(&mut regulator, 510..1500, 33.0, 25.0);
        assert_eq!(
            regulator.turn(at_ms(1500), Some(WANTED)).update.milliamps(),
            0
        );
        settled(&mut regulator, 1500..1530, 33.0, 25.0);
        assert_ne!(
            regulator.turn(at_ms(1530), Some(WANTED)).update.milliamps(),
            0
        );
    }
    let mut regulator = regulator();
    settled(&mut regulator, 0..500, 33.0, 25.0);
    let reading = Reading {
        at: at_ms(490),
        face: code(33.0),
        sink: code(25.0),
    };
    regulator.see(at_ms(590), &reading);
    assert_ne!(
        regulator.turn(at_ms(590), Some(WANTED)).update.milliamps(),
        0
    );
    regulator.see(at_ms(591), &reading);
    let turned = regulator.turn(at_ms(591), Some(WANTED));
    assert_eq!(
        turned.reason,
        Some(PeltierReason::Sensor(SensorFault::Stale))
    );
    assert_eq!(turned.update.milliamps(), 0);
}

#[test]
fn a_reading_that_never_came_drives_nothing() {
    let turned = regulator().turn(Instant::ZERO, Some(WANTED));
    assert_eq!((turned.update.milliamps(), turned.face_c), (0, None));
    assert_eq!(turned.reason, Some(PeltierReason::Off));
}

#[test]
fn an_update_ends_by_itself_and_nothing_wanted_is_off() {
    let mut regulator = regulator();
    settled(&mut regulator, 0..500, 33.0, 25.0);
    let turned = regulator.turn(at_ms(490), Some(WANTED));
    assert_eq!(turned.update.until(), at_ms(590));
    let off = regulator.turn(at_ms(500), None);
    assert_eq!((off.update.milliamps(), off.aim_c), (0, None));
}

/// What a module pumps out of its face, W.
fn pumped_w(amps: f64, face_c: f64, sink_c: f64) -> f64 {
    let p = PeltierParameters::default();
    p.seebeck_v_k * (face_c + ZERO_CELSIUS_K) * amps
        - amps * amps * p.resistance_ohm / 2.0
        - p.conductance_w_k * (sink_c - face_c)
}

#[test]
fn materials_meet_skin_where_half_spaces_do() {
    let at = |m: Material| m.contact_c(33.0, 23.0);
    let expected = [
        (Material::Metal, 23.47),
        (Material::Glass, 27.63),
        (Material::Wood, 31.03),
        (Material::Cloth, 31.85),
    ];
    for (material, celsius) in expected {
        let found = at(material);
        assert!(
            (found - celsius).abs() < 0.01,
            "{}: {found}",
            material.name()
        );
    }
    for material in Material::ALL {
        assert!((material.contact_c(33.0, 33.0) - 33.0).abs() < 1e-9);
    }
}

proptest! {
    /// Whatever is asked: no current over its limit, no heating of a hot face or cooling of a cold one, no cooling into a
    /// hot sink, and no ramp beyond the limit by the module's equation with the worst skin.
    #[test]
    fn every_current_keeps_to_every_row(
        asked in prop_oneof![-20.0..20.0, Just(f64::NAN), Just(f64::INFINITY)],
        face_c in 10.0..48.0_f64,
        sink_c in 5.0..60.0_f64,
    ) {
        let mut guard = CurrentGuard::new(PeltierParameters::default(), Thermistor::default());
        for ms in (0..500).step_by(10) {
            let reading = Reading { at: at_ms(ms), face: code(face_c), sink: code(sink_c) };
            guard.see(at_ms(ms), &reading);
        }
        let (update, _) = guard.admit(at_ms(490), asked);
        let amps = update.amps();
        let [low, high] = LIMITS.face_c;
        prop_assert!((-LIMITS.heating_a..=LIMITS.cooling_a).contains(&amps));
        prop_assert!(face_c < high - UNCERTAINTY_K + 0.05 || amps >= 0.0);
        prop_assert!(face_c > low + UNCERTAINTY_K - 0.05 || amps <= 0.0);
        prop_assert!(sink_c < LIMITS.sink_c - UNCERTAINTY_K + 0.05 || amps <= 0.0);
        let face_w = -pumped_w(amps, face_c, sink_c) - 0.1 * (face_c - 33.0);
        let passive_w = -pumped_w(0.0, face_c, sink_c) - 0.1 * (face_c - 33.0);
        let most_w = 0.43 * LIMITS.ramp_k_s + 2e-3;
        prop_assert!(face_w <= most_w.max(passive_w) && face_w >= (-most_w).min(passive_w));
        // And what is within every row passes.
        if asked.abs() < 0.05 && (20.0..38.0).contains(&face_c) && (10.0..40.0).contains(&sink_c) {
            prop_assert!((amps - asked).abs() < 1e-3);
        }
    }
}
