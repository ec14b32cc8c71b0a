//! Tests of `stamp.rs`.

use super::*;
use crate::can::socket::Content;

const MS: i64 = 1_000_000;

fn packet(software_ns: Option<i64>, hardware_ns: Option<i64>) -> Packet {
    Packet {
        content: Content::Other,
        software_ns,
        hardware_ns,
        dropped: None,
    }
}

/// Stamps on a clock that starts at 10 s of the monotonic one.
fn stamps() -> (Stamps, i64) {
    let clock = RunClock::start();
    let start = monotonic_ns();
    (Stamps::new(clock), start)
}

#[test]
fn the_kernels_stamp_says_how_old_a_frame_is() {
    let (mut stamps, start) = stamps();
    let now = start + 50 * MS;
    let at = stamps.at(&packet(Some(900 * MS), None), now, 907 * MS);
    assert_eq!(at, stamps.clock.instant(now - 7 * MS));
}

#[test]
fn a_clock_that_was_set_counts_for_nothing() {
    for realtime in [0, 5_000 * MS, i64::MAX] {
        let (mut stamps, start) = stamps();
        let at = stamps.at(&packet(Some(900 * MS), None), start + 50 * MS, realtime);
        assert_eq!(at, stamps.clock.instant(start + 50 * MS), "{realtime}");
    }
}

#[test]
fn frames_of_one_interface_stay_in_order() {
    let (mut stamps, start) = stamps();
    let first = stamps.at(&packet(None, None), start + 50 * MS, 0);
    let second = stamps.at(&packet(Some(900 * MS), None), start + 51 * MS, 910 * MS);
    assert!(second >= first);
}

#[test]
fn a_controllers_stamps_take_the_systems_delay_out() {
    let (mut stamps, start) = stamps();
    // Every 10 ms by the controller; seen 1 to 4 ms late.
    let seen = |n: i64| start + n * 10 * MS + (1 + n % 4) * MS;
    let mut times = Vec::new();
    for n in 1..=20 {
        times.push(stamps.at(&packet(None, Some(7 * MS + n * 10 * MS)), seen(n), 0));
    }
    for pair in times[4..].windows(2) {
        let apart = pair[1].since(pair[0]).as_micros();
        assert!((9_990..=10_010).contains(&apart), "{apart}");
    }
    assert_eq!(stamps.hardware(), 20);
    // Set anew: a new distance at once.
    let at = stamps.at(&packet(None, Some(1)), seen(21), 0);
    assert_eq!(at, stamps.clock.instant(seen(21)));
}
