//! Tests of `watchdog.rs`.

use super::*;

const fn ms(ms: u64) -> Instant {
    Instant::from_micros(ms * 1000)
}

fn dog() -> Watchdog {
    Watchdog::new(Duration::from_millis(100), Duration::from_millis(10))
}

#[test]
fn switching_time_is_taken_off_the_limit_up_to_half_of_it() {
    for (latency, patience) in [(0, 100), (10, 90), (50, 50), (51, 50), (1000, 50)] {
        let dog = Watchdog::new(Duration::from_millis(100), Duration::from_millis(latency));
        assert_eq!(dog.patience, Duration::from_millis(patience));
    }
}

#[test]
fn age_counts_from_the_newest_frame_and_only_while_a_wire_is_driven() {
    let mut dog = dog();
    assert_eq!(dog.look(ms(0), Some(ms(35))), Some(Cause::StaleInput));
    assert_eq!(dog.look(ms(0), None), None);
    assert_eq!(dog.deadline(), Instant::ZERO);
    dog.hear(ms(20));
    dog.hear(ms(10));
    assert_eq!(dog.deadline(), ms(110));
    for (now, stale) in [(20, false), (109, false), (110, true), (111, true)] {
        assert_eq!(dog.is_stale(ms(now)), stale);
        let cause = stale.then_some(Cause::StaleInput);
        assert_eq!(dog.look(ms(now), Some(ms(100))), cause);
        assert_eq!(dog.look(ms(now), None), None);
    }
}

#[test]
fn a_tick_is_late_once_an_end_is_long_past() {
    let mut dog = dog();
    dog.hear(ms(200));
    assert_eq!(dog.look(ms(189), Some(ms(100))), None);
    assert_eq!(dog.look(ms(190), Some(ms(100))), Some(Cause::LateTick));
    assert_eq!(dog.look(ms(190), None), None);
}

#[test]
fn a_latch_keeps_its_first_cause() {
    let mut dog = dog();
    dog.latch(Cause::LateTick);
    dog.latch(Cause::SensorError);
    assert_eq!(dog.latched(), Some(Cause::LateTick));
    dog.open();
    assert_eq!(dog.latched(), None);
}

#[test]
fn a_failed_bus_that_became_an_overrun_is_latched_as_that_and_no_other_cause_is() {
    let causes = [
        Cause::StaleInput,
        Cause::ActuatorError,
        Cause::SensorError,
        Cause::LateTick,
        Cause::End,
        Cause::Overrun,
    ];
    for first in causes {
        for later in causes {
            let mut dog = dog();
            dog.latch(first);
            dog.latch(later);
            let became = (first, later) == (Cause::ActuatorError, Cause::Overrun);
            let kept = if became { later } else { first };
            assert_eq!(dog.latched(), Some(kept));
            assert_eq!(first.followed_by(later), kept);
        }
    }
}

#[test]
fn all_is_well_when_frames_come_and_somebody_looks() {
    let mut dog = dog();
    assert_eq!(dog.ready(ms(5)), Err(Cause::StaleInput));
    dog.hear(ms(5));
    assert_eq!(dog.ready(ms(5)), Err(Cause::LateTick));
    dog.look(ms(5), None);
    assert_eq!(dog.ready(ms(5)), Ok(()));
    dog.hear(ms(95));
    assert_eq!(dog.ready(ms(95)), Err(Cause::LateTick));
    dog.look(ms(6), None);
    dog.look(ms(5), None);
    assert_eq!(dog.ready(ms(95)), Ok(()));
}

#[test]
fn causes_have_their_words() {
    let words = [
        (Cause::StaleInput, "stale-input"),
        (Cause::ActuatorError, "actuator-error"),
        (Cause::SensorError, "sensor-error"),
        (Cause::LateTick, "late-tick"),
        (Cause::Rezero, "rezero"),
        (Cause::End, "end"),
        (Cause::Overrun, "overrun"),
    ];
    for (cause, word) in words {
        assert_eq!(cause.word(), word);
    }
}
