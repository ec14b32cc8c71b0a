//! A tap's pulses: when they come, how they die away, and what hardness makes of them.

use alloc::vec::Vec;

use super::*;

/// 5.07904 ms.
const CARRIER: Prescale = Prescale::new(30);
const START: Instant = Instant::from_micros(1_000);
/// Time for which a pulse is on.
const ON: Duration = Duration::from_micros(2_600);
const TAPS: Taps = Taps {
    rate_mhz: Firmness {
        soft: 60_000,
        hard: 200_000,
    },
    strength: Firmness {
        soft: 0.5,
        hard: 1.0,
    },
    decay: Duration::from_millis(12),
};

/// Beginnings since the tap's own, and shares, played on time.
fn played(hardness: f64) -> Vec<(u64, f32)> {
    let mut tap = Tap::new(&TAPS, START, hardness, CARRIER);
    let mut all = Vec::new();
    while tap.next() < Instant::FAR_FUTURE {
        let now = tap.next();
        let (at, share) = tap.due(now, ON).unwrap();
        assert!(at == now && (at + ON).since(START) <= LENGTH);
        all.push((at.since(START).as_micros(), share));
    }
    all
}

#[test]
fn a_harder_surface_answers_with_more_and_stronger_pulses() {
    let [soft, middle, hard] = [0.0, 0.5, 1.0].map(played);
    assert_eq!(soft.len(), 3);
    assert_eq!(hard.len(), 8);
    assert!((soft.len()..=hard.len()).contains(&middle.len()));
    assert_eq!((soft[0], hard[0]), ((0, 0.5), (0, 1.0)));
    assert_eq!(soft[1].0, 15_237);
    assert_eq!(hard[1].0, 5_079);
    // what is out of range is at its end
    assert_eq!(played(-3.0), soft);
    assert_eq!(played(7.0), hard);
}

#[test]
fn pulses_die_away_in_the_time_that_was_asked_for() {
    for (at, share) in played(1.0) {
        let expected = (-(at as f64) / 12_000.0).exp();
        assert!((f64::from(share) - expected).abs() < 1e-6, "{at}: {share}");
    }
}

#[test]
fn missed_pulses_are_left_out() {
    let mut tap = Tap::new(&TAPS, START, 1.0, CARRIER);
    let late = START + Duration::from_millis(12);
    let found = tap.due(late, ON).map(|(at, _)| at.since(START).as_micros());
    assert_eq!(found, Some(10_158));
    assert_eq!(tap.due(START + Duration::from_millis(200), ON), None);
    assert_eq!(tap.next(), Instant::FAR_FUTURE);
}
