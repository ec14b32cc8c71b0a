//! The guard's arithmetic and hostile updates.

use super::*;
use crate::random::RandomStream;

/// Round numbers; no motor's data.
const LIMITS: MotorLimits = MotorLimits {
    rated_v: 2.0,
    travel_um_v: 50.0,
    travel_um: 90.0,
    rise_k_v2: 10.0,
    coil_s: 5.0,
    rise_k: 20.0,
};

fn guard() -> VibrationGuard {
    VibrationGuard::new(Instant::ZERO, LIMITS).expect("limits are sound")
}

#[test]
fn a_cold_motor_gets_what_is_asked_up_to_its_displacement() {
    let asked = [0.0, 0.25, 0.5, 1.0, 7.0, -1.0, f64::NAN, f64::INFINITY];
    let update = guard().admit(Instant::ZERO, &asked);
    assert_eq!(update.millivolts(), &[0, 500, 1000, 1800, 1800, 0, 0, 0]);
}

#[test]
fn a_limit_of_zero_is_no_guard() {
    let rated = MotorLimits {
        rated_v: 0.0,
        ..LIMITS
    };
    assert!(VibrationGuard::new(Instant::ZERO, rated).is_none());
}

#[test]
fn full_drive_settles_below_the_limit_of_the_coil() {
    // 1.8 V would settle at 32.4 K; the limit allows sqrt(20 / 10) = 1.414 V for ever.
    let mut guard = guard();
    let mut now = Instant::ZERO;
    for _ in 0..1000 {
        guard.admit(now, &[1.0; MOTORS]);
        now += HOLD;
    }
    let update = guard.admit(now, &[1.0; MOTORS]);
    assert!(
        update
            .millivolts()
            .iter()
            .all(|mv| (1410..=1414).contains(mv))
    );
    assert!(
        guard
            .rise_k()
            .iter()
            .all(|rise| (19.9..=20.0).contains(rise))
    );
}

#[test]
fn hostile_updates_pass_no_limit() {
    let mut stream = RandomStream::new(56, "hostile vibration");
    for _ in 0..50 {
        let mut guard = guard();
        let (mut now, mut rise_k, mut passed) = (Instant::ZERO, [0.0; MOTORS], 0u64);
        for _ in 0..500 {
            let asked = core::array::from_fn(|_| 3.0 * stream.uniform() - 0.5);
            let update = guard.admit(now, &asked);
            let step = Duration::from_millis(1 + stream.next_u64() % 100);
            now += step;
            for (rise, mv) in rise_k.iter_mut().zip(update.millivolts()) {
                let volts = f64::from(*mv) * 1e-3;
                assert!(volts <= 1.8, "{volts} V moves too far");
                let settled = 10.0 * volts * volts;
                *rise = settled + (*rise - settled) * libm::exp(-step.as_secs_f64() / 5.0);
                assert!(*rise <= 20.0 + 1e-9, "a coil is {rise} K warmer");
                passed += u64::from(*mv);
            }
        }
        assert!(
            passed > 500 * 8 * 500,
            "the guard refuses nearly everything"
        );
    }
}
