//! Tests of `uptime.rs`.

use super::*;

#[test]
fn only_the_same_start_and_a_clock_that_goes_on_tell_how_long_it_was() {
    let at = |boot, us| Uptime { boot, us };
    let span = |us| Some(Duration::from_micros(us));
    assert_eq!(at(7, 12).since(at(7, 5)), span(7));
    assert_eq!(at(7, 5).since(at(7, 5)), span(0));
    assert_eq!(at(7, 4).since(at(7, 5)), None, "it went back");
    assert_eq!(at(8, 12).since(at(7, 5)), None, "another start");
    assert_eq!(at(0, 12).since(at(0, 5)), None, "no start is known");
    assert_eq!(at(7, u64::MAX).after(Duration::from_micros(1)).us, u64::MAX);
}

#[test]
fn a_program_sees_one_start_and_a_clock_that_goes_on() {
    let (before, after) = (Uptime::now(), Uptime::now());
    assert!(before.boot == after.boot && after.us >= before.us);
    assert_eq!(before.boot, boot());
    assert_eq!(
        boot() > 1,
        uptime_start().is_some(),
        "no two starts are one"
    );
    let true_us = nanoseconds(ClockId::CLOCK_BOOTTIME) as u64 / 1000;
    assert!(true_us.abs_diff(after.us) < 10_000_000, "{after:?}");
}
