//! Tests of `pacer.rs`.

use super::*;

fn us(us: u64) -> Instant {
    Instant::from_micros(us)
}

#[test]
fn quantiles_are_upper_bounds_of_what_was_counted() {
    let mut lateness = Lateness::default();
    for late in [0, 0, 3, 100, 900] {
        lateness.note(us(1000), us(1000 + late));
    }
    lateness.note(us(5000), us(10)); // early is not late
    assert_eq!((lateness.turns(), lateness.worst_us()), (6, 900));
    assert_eq!(lateness.quantile_us(0.5), 0);
    assert_eq!(lateness.quantile_us(0.8), 127);
    assert_eq!(lateness.quantile_us(1.0), 900);
}

#[test]
fn a_late_turn_leaves_turns_out() {
    let step = Duration::from_millis(1);
    assert_eq!(Pacer::next(us(0), step), us(1000));
    assert_eq!(Pacer::next(us(999), step), us(1000));
    assert_eq!(Pacer::next(us(7300), step), us(8000));
    assert_eq!(Pacer::next(Instant::FAR_FUTURE, step), Instant::FAR_FUTURE);
}

#[test]
fn the_clock_never_wakes_early_and_does_not_wait_for_the_past() {
    let clock = RunClock::start();
    let mut pacer = Pacer::new(clock);
    for due in [us(500), us(2500), us(100)] {
        assert!(pacer.wait(due) >= due);
    }
    assert_eq!(pacer.lateness().turns(), 3);
    assert_eq!(clock.instant(i64::MIN), Instant::ZERO);
}

#[test]
fn time_that_a_loop_did_not_see_is_told_from_a_late_turn() {
    let at = |ms: u64| Instant::from_micros(ms * 1000);
    let mut watch = Watch::default();
    assert_eq!(watch.look_at(at(500), 7), None, "the first look");
    assert_eq!(
        watch.look_at(at(600), 20_000_007),
        None,
        "the bounds are seen"
    );
    let stood = watch.look_at(at(701), 20_000_007).unwrap();
    assert_eq!(
        (stood, stood.uncounted()),
        (Unseen::Stood(Duration::from_millis(101)), Duration::ZERO)
    );
    let slept = watch.look_at(at(702), 3_020_000_007).unwrap();
    assert_eq!(slept.uncounted(), Duration::from_millis(3000));
    assert!(
        slept.to_string().contains("suspended for 3000 ms"),
        "{slept}"
    );
    assert_eq!(watch.look_at(at(703), 0), None, "a clock that goes back");
}
