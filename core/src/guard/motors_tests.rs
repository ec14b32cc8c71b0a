//! Tests of `motors.rs`: every limit by arithmetic that a reader can follow, and hostile updates.

use super::*;
use crate::units::{Channel, Point, Prescale};
use alloc::vec;
use alloc::vec::Vec;
use proptest::prelude::*;

/// Figures that are easy to reckon with.
const EASY: MotorLimits = MotorLimits {
    rated_v: 2.0,
    overdrive_v: 3.0,
    overdrive_s: 0.01,
    travel_um_v: 50.0,
    travel_um: 1000.0,
    rise_k_v2: 5.0,
    coil_s: 10.0,
    rise_k: 1000.0,
    burst: Duration::from_millis(500),
    duty: 0.5,
};

fn places(count: u8) -> Vec<DisplayWire> {
    let place = |n: u8| DisplayWire {
        place: Point::new(f32::from(n), 0.0),
        board: Board(0),
        channel: Channel(n),
    };
    (0..count).map(place).collect()
}

fn guard(motors: MotorLimits) -> Guard {
    let plant = Plant {
        prescale: Prescale::new(30),
        ..Plant::default()
    };
    let mut guard = Guard::of_motors(super::super::HARD, motors, plant, &places(8)).unwrap();
    guard.hear(Instant::ZERO);
    guard
}

const fn ms(n: u64) -> Instant {
    Instant::from_micros(1000 * n)
}

fn stimulus(motor: u16, level: u16, at: Instant, until: Instant) -> Stimulus {
    Stimulus {
        wire: motor,
        width: Ticks::new(level),
        peak: crate::units::Milliamps(0),
        at,
        until,
    }
}

/// Level and entry of one stimulus of motor 0.
fn one(guard: &mut Guard, level: u16, at: Instant, until: Instant) -> (u8, Entry) {
    let mut entry = None;
    let update = guard
        .admit_vibration(at, Board(0), &[stimulus(0, level, at, until)], |e| {
            entry = Some(e);
        })
        .unwrap();
    let level = update.levels()[0].unwrap_or(0);
    (level, entry.unwrap())
}

#[test]
fn full_level_is_the_rated_voltage_and_levels_are_rounded_down() {
    let mut guard = guard(EASY);
    let (level, entry) = one(&mut guard, 4096, ms(0), ms(100));
    assert_eq!((level, entry.reason), (127, None));
    let (level, _) = one(&mut guard, 2048, ms(200), ms(300));
    assert_eq!(level, 63); // half of 127 is 63.5
    let (level, _) = one(&mut guard, 32, ms(400), ms(500));
    assert_eq!(level, 0); // less than a step of 127
}

#[test]
fn displacement_bounds_the_voltage() {
    // 60 um at 50 um/V are 1.2 V of 2 V: three fifths of 4096 are 2457.
    let mut guard = guard(MotorLimits {
        travel_um: 60.0,
        ..EASY
    });
    let (level, entry) = one(&mut guard, 4096, ms(0), ms(100));
    assert_eq!(entry.off, 2457);
    assert_eq!(entry.reason, Some(Reason::Displacement));
    assert_eq!(level, 76);
    let (_, entry) = one(&mut guard, 2457, ms(200), ms(300));
    assert_eq!((entry.off, entry.reason), (2457, None));
}

#[test]
fn a_burst_ends_at_its_limit_and_a_motor_rests_before_the_next() {
    let mut guard = guard(EASY);
    let (level, entry) = one(&mut guard, 4096, ms(0), ms(2000));
    assert_eq!(level, 127);
    assert_eq!(entry.reason, Some(Reason::Burst));
    assert!(entry.until <= ms(500) && entry.until > ms(490), "{entry:?}");
    // It goes on without a gap: the same burst, which is over.
    let (level, entry) = one(&mut guard, 4096, ms(500), ms(600));
    assert_eq!((level, entry.reason), (0, Some(Reason::Burst)));
    let (level, _) = one(&mut guard, 4096, ms(700), ms(800));
    assert_eq!(level, 127);
}

#[test]
fn the_coil_warms_by_voltage_and_overdrive_and_bounds_both() {
    // One second of full level: 5 K/V2 x 4 V2 x (1 - exp(-0.4/10)), and overdrive 5 x 9 x (1 - exp(-0.02/10)).
    let mut warm = guard(EASY);
    one(&mut warm, 4096, ms(0), ms(400));
    let steady = 20.0 * (1.0 - (-0.04_f64).exp());
    let overdrive = 45.0 * (1.0 - (-0.002_f64).exp());
    let predicted = warm.coil_rise_k(ms(400));
    assert!(
        (predicted - steady - overdrive).abs() < 1e-12,
        "{predicted}"
    );
    // Ten seconds later an e-th is left.
    let later = warm.coil_rise_k(ms(10_400));
    assert!((later - predicted / core::f64::consts::E).abs() < 1e-12);
    // Half the rise is allowed: the voltage that gives it, downwards.
    let most = MotorLimits {
        rise_k: (steady + overdrive) / 2.0,
        ..EASY
    };
    let mut bound = guard(most);
    let (_, entry) = one(&mut bound, 4096, ms(0), ms(400));
    assert_eq!(entry.reason, Some(Reason::CoilHeat));
    let square = ((steady + overdrive) / 2.0 - overdrive) / (5.0 * (1.0 - (-0.04_f64).exp()));
    assert_eq!(f64::from(entry.off), (square.sqrt() / 2.0 * 4096.0).floor());
    assert!(bound.coil_rise_k(ms(400)) <= most.rise_k);
}

#[test]
fn the_coil_s_earlier_heat_leaves_less() {
    let mut guard = guard(MotorLimits {
        rise_k: 1.2,
        ..EASY
    });
    one(&mut guard, 4096, ms(0), ms(400));
    guard.expire_vibration(ms(400), Board(0)).unwrap();
    let before = guard.coil_rise_k(ms(440));
    let kept = libm::exp(-0.04);
    let room = 1.2 - before * kept - 45.0 * (1.0 - libm::exp(-0.002));
    let volts = (room / (5.0 * (1.0 - kept))).sqrt();
    let (_, entry) = one(&mut guard, 4096, ms(440), ms(840));
    assert_eq!(f64::from(entry.off), (volts / 2.0 * 4096.0).floor());
    assert_eq!(entry.reason, Some(Reason::CoilHeat));
    assert!((guard.coil_rise_k(ms(840)) - 1.2).abs() < 1e-3);
}

#[test]
fn the_duty_cuts_a_burst_to_the_time_that_is_left() {
    // 5 s of ten, less four fifths of a half of 10.5 s.
    assert!((EASY.saved_s() - 0.8).abs() < 1e-12);
    let mut guard = guard(EASY);
    let left_us = |guard: &mut Guard, at: u64| {
        let (_, entry) = one(guard, 4096, ms(at), ms(at + 490));
        guard.expire_vibration(entry.until, Board(0)).unwrap();
        (entry.until.since(ms(at)).as_micros(), entry.reason)
    };
    // While it is on, a motor uses six tenths of the time; in 30 ms off it saves up 12 ms.
    assert_eq!(left_us(&mut guard, 0), (490_000, None)); // 0.8 s before, 0.506 s after
    assert_eq!(left_us(&mut guard, 520), (490_000, None)); // 0.518 s and 0.224 s
    let (cut_us, reason) = left_us(&mut guard, 1040); // 0.236 s
    assert!((235_998..=236_000).contains(&cut_us), "{cut_us}");
    assert_eq!(reason, Some(Reason::Duty));
}

#[test]
fn a_stimulus_as_long_as_the_time_that_is_left_is_whole() {
    let limits = MotorLimits {
        burst: Duration::from_millis(2000),
        ..EASY
    };
    let (_, cut) = one(&mut guard(limits), 4096, ms(0), ms(1000));
    assert_eq!(cut.reason, Some(Reason::Duty));
    let (_, whole) = one(&mut guard(limits), 4096, ms(0), cut.until);
    assert_eq!((whole.until, whole.reason), (cut.until, None));
}

#[test]
fn no_ten_seconds_have_more_than_the_duty() {
    let mut guard = guard(EASY);
    let mut on = Vec::new();
    for n in 0..400 {
        let at = ms(100 * n);
        guard.hear(at);
        let (level, entry) = one(&mut guard, 4096, at, at + Duration::from_millis(60));
        if level > 0 {
            on.push((entry.at.as_micros(), entry.until.as_micros()));
            guard.expire_vibration(entry.until, Board(0)).unwrap();
        }
    }
    let most = on.iter().map(|&(from, _)| {
        let end = from + 10_000_000;
        let in_window = on.iter().filter(|(at, _)| *at >= from && *at < end);
        in_window
            .map(|(at, until)| until.min(&end) - at)
            .sum::<u64>()
    });
    let most = most.max().unwrap();
    assert!(most <= 5_000_000, "{most} us");
    // Refusing everything does not pass.
    assert!(most > 4_400_000, "{most} us");
}

#[test]
fn a_guard_of_motors_passes_no_wire_and_a_guard_of_wires_no_motor() {
    let mut motors = guard(EASY);
    let mut entries = Vec::new();
    let stimuli = [stimulus(0, 100, ms(0), ms(10))];
    let update = motors.admit(ms(0), Board(0), &stimuli, |e| entries.push(e));
    assert!(!update.changes());
    assert_eq!(entries[0].reason, Some(Reason::Plant));
    let worn = super::super::WornWire::default();
    let wires = Guard::new(super::super::HARD, Plant::default(), &places(8), worn);
    let mut wires = wires.unwrap();
    wires.hear(ms(0));
    let passed = wires.admit_vibration(ms(0), Board(0), &stimuli, |_| panic!("no entry"));
    assert_eq!(passed, None);
    assert_eq!(wires.expire_vibration(ms(50), Board(0)), None);
    assert!(wires.motors().is_none() && motors.motors().is_some());
}

#[test]
fn nothing_is_booked_for_what_is_refused() {
    let mut still = guard(MotorLimits {
        travel_um: 0.01,
        ..EASY
    });
    let (level, entry) = one(&mut still, 4096, ms(0), ms(100));
    assert_eq!((level, entry.off), (0, 0));
    assert_eq!(entry.reason, Some(Reason::Displacement));
    assert!(still.coil_rise_k(ms(0)) <= 0.0);
    // A stimulus that is over already, and one of no level, are refused for no limit.
    let mut guard = guard(EASY);
    let (_, over) = one(&mut guard, 4096, ms(100), ms(50));
    assert_eq!((over.off, over.reason), (0, None));
    let (_, none) = one(&mut guard, 0, ms(100), ms(150));
    assert_eq!((none.off, none.reason), (0, None));
    assert!(guard.coil_rise_k(ms(200)) <= 0.0);
}

#[test]
fn an_update_says_whether_it_changes_anything_and_is_confirmed() {
    let mut guard = guard(EASY);
    let on = [stimulus(0, 4096, ms(0), ms(400))];
    let update = guard.admit_vibration(ms(0), Board(0), &on, |_| ()).unwrap();
    assert!(update.changes());
    let nothing = guard.expire_vibration(ms(10), Board(0)).unwrap();
    assert!(!nothing.changes());
    let off = guard.expire_vibration(ms(400), Board(0)).unwrap();
    assert!(off.changes());
    // Without an answer of the driver the motor counts as on, for too long in the end.
    let late = ms(600);
    let mut unsure = guard.clone();
    unsure.hear(late);
    assert_eq!(unsure.watch(late), Some(super::super::Cause::Overrun));
    guard.confirm_vibration(&off, ms(401));
    guard.hear(late);
    assert_ne!(guard.watch(late), Some(super::super::Cause::Overrun));
}

#[test]
fn a_late_end_counts_as_time_and_heat() {
    let mut guard = guard(EASY);
    one(&mut guard, 4096, ms(0), ms(100));
    let booked = guard.coil_rise_k(ms(100));
    guard.expire_vibration(ms(300), Board(0)).unwrap();
    assert!(guard.coil_rise_k(ms(300)) > booked);
}

#[test]
fn limits_that_cannot_be_are_refused() {
    let bad = [
        MotorLimits {
            rated_v: 0.0,
            ..EASY
        },
        MotorLimits { duty: 1.5, ..EASY },
        MotorLimits {
            coil_s: f64::NAN,
            ..EASY
        },
        MotorLimits {
            travel_um: f64::INFINITY,
            ..EASY
        },
        MotorLimits {
            burst: Duration::ZERO,
            ..EASY
        },
    ];
    for limits in bad {
        let made = Guard::of_motors(super::super::HARD, limits, Plant::default(), &places(1));
        assert!(matches!(made, Err(PlantError::Motor)), "{limits:?}");
    }
}

proptest! {
    /// Whatever is asked, no coil passes its rise by a model that is stepped through beside, no contactor its displacement, no
    /// motor its duty.
    #[test]
    fn hostile_updates_pass_no_limit(
        asked in prop::collection::vec((0u64..400, 0u16..8, any::<u16>(), 0u64..1500), 1..200),
        rise_k in 0.5_f64..20.0,
        travel_um in 1.0_f64..150.0,
    ) {
        let limits = MotorLimits { rise_k, travel_um, ..EASY };
        let mut guard = guard(limits);
        let mut runs: Vec<Vec<(f64, f64, f64)>> = vec![Vec::new(); 8];
        let mut now = 0;
        for (wait, motor, level, length) in asked {
            now += wait;
            guard.hear(ms(now));
            let stimuli = [stimulus(motor, level, ms(now), ms(now + length))];
            let update = guard.admit_vibration(ms(now), Board(0), &stimuli, |_| ()).unwrap();
            for (index, set) in update.levels().into_iter().enumerate().take(8) {
                let Some(level) = set else { continue };
                let at = now as f64 * 1e-3;
                if let Some(last) = runs[index].last_mut() {
                    last.1 = last.1.min(at);
                }
                let volts = 2.0 * f64::from(level) / 127.0;
                let until = update.0.ends()[index].as_micros() as f64 * 1e-6;
                prop_assert!(volts * 50.0 <= travel_um + 1e-9);
                if level > 0 {
                    runs[index].push((at, until, volts));
                }
            }
        }
        for run in &runs {
            let (mut rise, mut at) = (0.0_f64, 0.0);
            for &(from, to, volts) in run {
                prop_assert!(to - from <= 0.5 + 1e-9);
                rise *= (-(from - at) / 10.0_f64).exp();
                let kept = (-(to - from) / 10.0_f64).exp();
                rise = rise * kept + 5.0 * volts * volts * (1.0 - kept);
                at = to;
                prop_assert!(rise <= rise_k + 1e-9, "{rise} of {rise_k} K");
            }
        }
    }
}

#[test]
fn the_used_share_of_every_limit_is_that_of_the_arithmetic() {
    let limits = MotorLimits {
        travel_um: 200.0,
        rise_k: 10.0,
        ..EASY
    };
    let mut guard = guard(limits);
    let used = |guard: &Guard, at: Instant| guard.motors_used(at).unwrap();
    let rest = [
        ("displacement", 0.0),
        ("coil-heat", 0.0),
        ("burst", 0.0),
        ("duty", 0.0),
    ];
    assert_eq!(used(&guard, ms(0)), rest);
    // Half of 2 V is 50 um. Coil: 5 K/V2 times (1 V)2 for 250 ms and (3 V)2 for 20 ms of 10 s. Duty: of 0.8 s saved up,
    // 250 ms are spent and 100 ms come back meanwhile.
    one(&mut guard, 2048, ms(1000), ms(1250));
    let shares = used(&guard, ms(1250)).map(|(_, share)| share);
    let coil_k = 5.0 * (1.0 - (-0.025_f64).exp()) + 45.0 * (1.0 - (-0.002_f64).exp());
    // A burst ends earlier by what its end may be late.
    let burst = 0.25
        / guard
            .latest(&guard.burst_at(0, ms(1000)))
            .since(ms(1000))
            .as_secs_f64();
    let wanted = [0.25, coil_k / 10.0, burst, 0.15 / 0.8];
    for (share, wanted) in shares.into_iter().zip(wanted) {
        assert!((share - wanted).abs() < 1e-9, "{shares:?}");
    }
    assert!((0.5..0.51).contains(&burst), "{burst}");
    let off = guard.expire_vibration(ms(1250), Board(0)).unwrap();
    guard.confirm_vibration(&off, ms(1250));
    for (_, share) in used(&guard, ms(600_000)) {
        assert!(share < 1e-9, "{share}");
    }
}

#[test]
fn motors_of_an_unknown_past_begin_at_their_limits_and_are_as_new_a_while_later() {
    let tight = MotorLimits {
        rise_k: 10.0,
        ..EASY
    };
    let mut guard = guard(tight).after_unknown_use();
    assert!((guard.coil_rise_k(ms(0)) - 10.0).abs() < 1e-9);
    // No time on is saved up: the update passes nothing.
    let (level, entry) = one(&mut guard, 4096, ms(0), ms(100));
    assert_eq!((level, entry.reason), (0, Some(Reason::CoilHeat)));
    // A second saves up four fifths of half of it, and the coil has lost a tenth of its rise.
    let (level, entry) = one(&mut guard, 256, ms(1000), ms(2000));
    assert_eq!(level, 7);
    assert_eq!((entry.until, entry.reason), (ms(1400), Some(Reason::Duty)));
    let off = guard.expire_vibration(ms(1400), Board(0)).unwrap();
    guard.confirm_vibration(&off, ms(1400));
    let (level, entry) = one(&mut guard, 4096, ms(60_000), ms(60_400));
    assert_eq!((level, entry.reason), (127, None));
}
