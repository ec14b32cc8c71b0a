//! Tests of `pattern.rs`.

use super::*;

const fn ms(ms: u64) -> Duration {
    Duration::from_millis(ms)
}

#[test]
fn a_vibration_of_three_pulses_lasts_30_ms_and_leaves_the_pause() {
    let pattern = Pattern::new(CADENCE, 2).unwrap();
    assert_eq!((pattern.prescale().get(), pattern.pulses(false)), (92, 3));
    assert_eq!(pattern.pulses(true), 2);
    // 15.24 ms apart: 30.5 ms from the first pulse to the last.
    assert_eq!(pattern.timing().duration, Duration::from_micros(38_092));
}

#[test]
fn every_cadence_gets_the_fewest_pulses_that_last_30_ms_where_any_do() {
    for soa in 45..300 {
        let pattern = Pattern::new(ms(soa), 2).unwrap();
        let pulses = u64::from(pattern.pulses(false));
        let first_to_last = (pulses - 1) * pattern.prescale().period_ns();
        let Timing { duration, soa } = pattern.timing();
        assert!(
            duration <= LONGEST && duration + APART <= soa,
            "{pattern:?}"
        );
        if soa >= Duration::from_micros(56_000) {
            assert!(first_to_last >= VIBRATION_US * 1000, "{pattern:?}");
        }
    }
    // Of three pulses 30.5 of 38.1 ms lie between first and last. 58.5 ms leave 37.3, in which they end early.
    let of = |us: u64| {
        let pattern = Pattern::new(Duration::from_micros(us), 2).unwrap();
        (pattern.pulses(false), pattern.lasts(3).as_micros())
    };
    assert_eq!(of(58_500), (3, 34_283));
    assert_eq!(of(60_000), (3, 38_092));
    assert_eq!(of(55_000).0, 6);
}

#[test]
fn pulses_are_as_many_at_every_oscillator() {
    for soa in [45, 58, 117, 234] {
        let pattern = Pattern::new(ms(soa), 2).unwrap();
        for pulses in 1..=pattern.pulses(false) {
            for mhz in [23.0, 25.0, 27.4] {
                let period_us = pattern.prescale().period_ns() as f64 * 1e-3 * 25.0 / mhz;
                let periods = pattern.lasts(pulses).as_micros() as f64 / period_us;
                assert!(
                    periods.ceil() as u8 == pulses || pulses > 4,
                    "{pulses} at {mhz} MHz: {periods}"
                );
            }
        }
    }
}

#[test]
fn small_pulses_come_in_larger_numbers() {
    let pattern = Pattern::new(CADENCE, 4).unwrap();
    assert_eq!((pattern.prescale().get(), pattern.pulses(false)), (61, 4));
}

#[test]
fn boards_with_a_spacing_of_their_own_get_what_fits() {
    let of = |prescale, soa| Pattern::on(Prescale::new(prescale), ms(soa)).map(|p| p.pulses(false));
    assert_eq!(of(30, 117), Ok(7)); // six periods of 5.08 ms are 30.5 ms
    assert_eq!(of(30, 45), Ok(5)); // the last of them has half a period
    assert_eq!(of(255, 117), Err(PatternError));
    assert_eq!(Pattern::new(ms(21), 2), Err(PatternError));
}
