//! What holds for the Peltier module of every kind of unit.

use palpate_core::codec::link::{Face, MOST, State, Warmth};
use palpate_core::driver::UnitDriver;
use palpate_core::guard::Cause;
use palpate_core::peltier::{LIMITS, PeltierReason};
use palpate_core::units::Duration;

use super::held::{STEP, Subject, host, speak};

const TENTH: Duration = Duration::from_millis(100);

/// A host that has met its unit.
fn met(subject: &mut impl Subject) -> UnitDriver {
    let mut driver = host(1);
    speak(subject, &mut driver, TENTH);
    assert!(driver.hello().unwrap().warmth);
    driver
}

/// What its module is now, by its newest report, within every row.
fn face(driver: &UnitDriver) -> Face {
    let face = driver.status().unwrap().face;
    let [low, high] = LIMITS.face_c.map(|c| (c * 1e3) as u16);
    assert!((low..=high).contains(&face.face_mc), "{face:?}");
    assert!(face.milliamps.unsigned_abs() <= 1000, "{face:?}");
    face
}

/// The face becomes what a host wants, no faster than it may, and is let go when the host wants nothing.
pub fn shows_what_is_cold(mut subject: impl Subject) {
    let mut driver = met(&mut subject);
    let mut before = face(&driver).face_mc;
    driver.warm(Some(Warmth {
        face_mc: 23_500,
        ceiling_mc: 41_000,
    }));
    for _ in 0..6 {
        speak(&mut subject, &mut driver, Duration::from_millis(1000));
        let face = face(&driver);
        // What a code of the converter comes to, beside the ramp.
        let most = (LIMITS.ramp_k_s * 1e3) as u16 + 300;
        assert!(face.face_mc.abs_diff(before) <= most, "{before} {face:?}");
        before = face.face_mc;
    }
    let there = face(&driver);
    assert!(there.face_mc.abs_diff(23_500) <= 300, "{there:?}");
    assert_eq!((there.aim_mc, there.reason), (23_500, None), "{there:?}");
    assert!(there.milliamps > 100 && there.sink_mc > 25_000, "{there:?}");
    driver.warm(None);
    speak(&mut subject, &mut driver, TENTH);
    let gone = face(&driver);
    let nothing = (0, 0, Some(PeltierReason::Off));
    assert_eq!((gone.milliamps, gone.aim_mc, gone.reason), nothing);
    assert_eq!(subject.end().high, 0);
}

/// The unit's own guard of the wires says how warm the face may become, whatever a host says.
pub fn bears_what_its_own_guard_bears(mut subject: impl Subject) {
    let mut driver = met(&mut subject);
    let warms = driver.hello().unwrap().heat;
    driver.warm(Some(Warmth {
        face_mc: 45_000,
        ceiling_mc: 45_000,
    }));
    let mut warmest = 0;
    for _ in 0..50 {
        speak(&mut subject, &mut driver, TENTH);
        warmest = warmest.max(face(&driver).face_mc);
    }
    let aim = face(&driver).aim_mc;
    match warms {
        // A kelvin inside the face's row, without stimuli.
        true => assert!((39_000..=40_000).contains(&aim) && warmest > 38_000),
        // Skin at rest, less what a thermistor may be off.
        false => assert!(aim == 32_500 && warmest < 33_500, "{aim} {warmest}"),
    }
    assert_eq!(subject.end().high, 0);
}

/// Nothing flows for a host whose reading is old, and again for one whose reading is new.
pub fn lets_go_without_a_reading(mut subject: impl Subject) {
    let mut driver = met(&mut subject);
    driver.warm(Some(Warmth {
        face_mc: 20_000,
        ceiling_mc: 41_000,
    }));
    speak(&mut subject, &mut driver, Duration::from_millis(1000));
    assert!(face(&driver).milliamps > 0);
    let old = subject.now();
    let mut buffer = [0; MOST];
    while subject.now().since(old) < Duration::from_millis(150) {
        if let Some(datagram) = driver.datagram(subject.now(), Some(old), &mut buffer) {
            subject.send(datagram);
        }
        for mut datagram in subject.pass(STEP) {
            let _ = driver.hear(subject.now(), &mut datagram);
        }
    }
    let silent = face(&driver);
    let nothing = (0, Some(PeltierReason::Off));
    assert_eq!((silent.milliamps, silent.reason), nothing, "{silent:?}");
    speak(&mut subject, &mut driver, TENTH);
    assert!(face(&driver).milliamps > 0);
    let state = driver.status().unwrap().state;
    assert!(matches!(
        state,
        State::Ready | State::Stopped(Cause::StaleInput)
    ));
    assert_eq!(subject.end().high, 0);
}
