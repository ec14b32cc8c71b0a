//! Tests of `rest.rs`.

use super::super::{Limits, Plant};
use super::*;
use crate::guard::thermal::Tissue;
use crate::guard::{HARD, WornWire};
use crate::illusion::DisplayWire;
use crate::schedule::Stimulus;
use crate::units::{Board, Channel, Milliamps, Point, Ticks};
use alloc::vec::Vec;
use proptest::prelude::*;

fn guard() -> Guard {
    let wire = |n: u8| DisplayWire {
        place: Point::new(9.0 * f32::from(n), 0.0),
        board: Board(0),
        channel: Channel(n),
    };
    Guard::new(
        HARD,
        Plant::default(),
        &[wire(0), wire(1)],
        WornWire::default(),
    )
    .unwrap()
}

fn at_ms(ms: u64) -> Instant {
    Instant::from_micros(1000 * ms)
}

/// A burst of 38 ms on the first wire.
fn burst(guard: &mut Guard, from_ms: u64) {
    let stimulus = Stimulus {
        wire: 0,
        width: Ticks::new(100),
        peak: Milliamps(990),
        at: at_ms(from_ms),
        until: at_ms(from_ms + 38),
    };
    guard.hear(stimulus.at);
    let _ = guard.admit(stimulus.at, Board(0), &[stimulus], |_| ());
    let _ = guard.expire(stimulus.until, Board(0));
}

/// Mean power, mW, that the rows of heat leave a wire over the ten seconds from `from` on.
fn ten_seconds_mw(guard: &Guard, from: Instant) -> [f64; 4] {
    let rooms = guard.rooms(0, from, from + Duration::from_millis(10_000));
    rooms.unwrap().map(|(joules, _)| joules * 100.0)
}

/// The values of the model that the face is coupled by: in the worst corner a milliwatt over ten seconds warms tissue by
/// 0.35 K at its end and by 0.294 K in the mean. The guard's own sums lie above both, so it leaves less.
#[test]
fn a_warm_face_leaves_a_wire_what_the_worst_corner_bears() {
    for face_c in [33.0, 35.0, 38.0, 40.0] {
        let mut guard = guard();
        guard.warm(Instant::ZERO, face_c, face_c);
        let [peak, _, _, mean] = ten_seconds_mw(&guard, at_ms(20));
        let (peak_mw, mean_mw) = ((43.0 - face_c) / 0.35, (41.0 - face_c) / 0.294);
        assert!(
            peak <= peak_mw && peak > 0.8 * peak_mw,
            "{face_c}: {peak} of {peak_mw}"
        );
        assert!(
            mean <= mean_mw && mean > 0.6 * mean_mw,
            "{face_c}: {mean} of {mean_mw}"
        );
    }
    let mut guard = guard();
    // With nothing booked the face may come to what the tissue may have in the mean, not below it and not far from it.
    let bears_c = guard.warm(Instant::ZERO, 33.0, 41.0);
    assert!((39.0..=43.0).contains(&bears_c), "{bears_c}");
    guard.warm(Instant::ZERO, 41.0, 41.0);
    assert!(ten_seconds_mw(&guard, at_ms(20))[3] < 0.0);
}

#[test]
fn a_cold_face_changes_nothing_and_a_warm_one_is_remembered() {
    let plain = ten_seconds_mw(&guard(), at_ms(20));
    let mut cold = guard();
    cold.warm(Instant::ZERO, 15.0, 15.0);
    assert_eq!(ten_seconds_mw(&cold, at_ms(20)), plain);
    let mut warm = guard();
    warm.warm(Instant::ZERO, 38.0, 33.0);
    for second in 1..=13 {
        warm.warm(at_ms(1000 * second), 33.0, 33.0);
        assert!(ten_seconds_mw(&warm, at_ms(20))[0] < plain[0], "{second}");
    }
    warm.warm(at_ms(14_000), 33.0, 33.0);
    assert_eq!(ten_seconds_mw(&warm, at_ms(20)), plain);
}

#[test]
fn a_face_that_gets_warm_is_in_what_is_predicted_of_bursts_before() {
    let mut guard = guard();
    guard.warm(Instant::ZERO, 33.0, 33.0);
    burst(&mut guard, 20);
    let before = guard.predicted().peak_c;
    guard.warm(at_ms(60), 33.0, 33.0);
    assert_eq!(guard.predicted().peak_c, before);
    guard.warm(at_ms(70), 38.0, 38.0);
    // The burst's own rise has worn off in part.
    let after = guard.predicted().peak_c;
    assert!(after > 38.0 && after > before, "{before} to {after}");
}

#[test]
fn a_warm_face_uses_rows_of_heat() {
    let mut guard = guard();
    let free = guard.used(at_ms(10));
    guard.warm(at_ms(10), 37.0, 37.0);
    let used = guard.used(at_ms(20));
    assert_eq!(
        (free.skin_mean, free.skin_peak, free.skin_deep),
        (0.0, 0.0, 0.0)
    );
    // Four kelvin of the eight or ten that rows leave above skin at rest, and a little less for latent heat.
    for (share, most_k) in [
        (used.skin_mean, 8.0),
        (used.skin_peak, 10.0),
        (used.skin_deep, 8.0),
    ] {
        assert!(share >= 4.0 / most_k && share < 4.5 / most_k, "{used:?}");
    }
    burst(&mut guard, 20);
    let more = guard.used(at_ms(58));
    assert!(more.skin_mean > used.skin_mean, "{used:?} to {more:?}");
    assert!(more.skin_peak > used.skin_peak, "{used:?} to {more:?}");
    assert!(more.skin_deep > used.skin_deep, "{used:?} to {more:?}");
}

#[test]
fn the_dose_of_a_burst_counts_from_the_face() {
    let omega = |face_c: f64| {
        let mut guard = guard();
        guard.warm(Instant::ZERO, face_c, face_c);
        burst(&mut guard, 20);
        guard.predicted().omega
    };
    // Henriques' rate grows by e for every 1.25 K at these temperatures: by 270 for seven.
    assert!(omega(40.0) > 100.0 * omega(33.0) && omega(33.0) >= 0.0);
}

#[test]
fn a_time_that_goes_back_forgets_nothing() {
    let mut rest = Rest::default();
    rest.raise(at_ms(0), 5.0);
    let last = BIN.as_micros() / 1000 * (BINS as u64 - 1);
    for ms in [last, last / 2, last] {
        rest.raise(at_ms(ms), 0.0);
        assert_eq!(rest.k(), 5.0, "{ms}");
    }
}

#[test]
fn what_is_no_number_leaves_nothing() {
    let mut guard = guard();
    guard.warm(Instant::ZERO, f64::NAN, 33.0);
    assert!(
        ten_seconds_mw(&guard, at_ms(20))
            .iter()
            .all(|mw| *mw <= 0.0)
    );
}

#[test]
fn a_guard_without_thermal_rows_bears_no_warm_face() {
    let wire = [DisplayWire {
        place: Point::new(0.0, 0.0),
        board: Board(0),
        channel: Channel(0),
    }];
    let mut guard = Guard::last_word(HARD, Plant::default(), &wire, None).unwrap();
    assert_eq!(guard.warm(Instant::ZERO, 38.0, 40.0), 33.0);
}

#[derive(Clone, Copy, Debug)]
struct Step {
    after_ms: u64,
    width: u16,
    length_ms: u64,
    face_c: f64,
}

fn steps() -> impl Strategy<Value = Vec<Step>> {
    let step = (5_u64..900, 0_u16..400, 1_u64..60, 10.0..45.0_f64);
    let step = step.prop_map(|(after_ms, width, length_ms, face_c)| Step {
        after_ms,
        width,
        length_ms,
        face_c,
    });
    prop::collection::vec(step, 1..60)
}

proptest! {
    /// The wires' rules are never loosened by a face: of the same past, no stimulus passes wider or longer with a face than
    /// without one; and a face that keeps to what [`Guard::warm`] returns passes no limit with what is booked.
    #[test]
    fn a_face_never_loosens_a_rule(steps in steps()) {
        let mut guard = guard();
        let (mut now, mut face_c) = (Instant::ZERO, 33.0_f64);
        let limits: Limits = HARD;
        for step in steps {
            now += Duration::from_millis(step.after_ms);
            let ceiling_c = guard.warm(now, face_c, step.face_c.min(41.0));
            // As fast as the face may, no warmer than the guard bears.
            let most = 3e-3 * step.after_ms as f64;
            face_c += (step.face_c.min(ceiling_c) - face_c).clamp(-most, most);
            guard.warm(now, face_c, step.face_c.min(41.0));
            let stimulus = Stimulus {
                wire: 0,
                width: Ticks::new(step.width),
                peak: Milliamps(990),
                at: now,
                until: now + Duration::from_millis(step.length_ms),
            };
            // Of the same past, as if no face had ever been.
            let mut without = guard.clone();
            if let Some(heat) = &mut without.heat {
                let cold = |t: &mut Tissue| (t.face_k, t.rest_k) = (0.0, 0.0);
                heat.tissues.iter_mut().for_each(cold);
            }
            let (mut with_it, mut free) = (None, None);
            without.admit(now, Board(0), &[stimulus], |entry| free = Some(entry));
            guard.admit(now, Board(0), &[stimulus], |entry| with_it = Some(entry));
            let (with_it, free) = (with_it.unwrap(), free.unwrap());
            prop_assert!(with_it.width() <= free.width());
            prop_assert!(with_it.until <= free.until);
            // Where the guard cut it: what is on for longer is booked as well, whatever the limits leave.
            guard.expire(with_it.until, Board(0));
            now = stimulus.until;
            let predicted = guard.predicted();
            prop_assert!(predicted.peak_c <= limits.skin_peak_mc as f64 * 1e-3 + 1e-6);
            prop_assert!(predicted.mean_c <= limits.skin_mean_mc as f64 * 1e-3 + 1e-6);
            prop_assert!(predicted.deep_c <= limits.skin_deep_mc as f64 * 1e-3 + 1e-6);
        }
    }
}
