//! Times that cannot be, and those that can.

use super::*;

/// 16 taxels at 100 Hz on one bus, their times through `warp`.
fn log(warp: impl Fn(u64) -> u64) -> Result<(), String> {
    let mut pace = Pace::new(USUAL_BITRATE);
    for k in 0..1280u64 {
        let us = k / 16 * 10_000 + k % 16 * 116;
        pace.frame((0, (k % 16) as u16, 8), warp(us))?;
    }
    pace.end()
}

#[test]
fn a_bus_at_its_usual_pace_passes_and_what_no_bus_carries_is_refused() {
    assert_eq!(log(|us| us), Ok(()));
    assert_eq!(
        log(|us| us / 1000 * 1000),
        Ok(()),
        "a clock of milliseconds"
    );
    assert!(log(|_| 0).unwrap_err().contains("of one instant"));
    assert!(log(|us| us / 1000).unwrap_err().contains("kbit/s"));
    assert!(log(|us| us % 10_000).unwrap_err().contains("differences"));
    assert!(log(|us| us * 1000).unwrap_err().contains("thousandfold"));
}

#[test]
fn few_frames_of_one_instant_are_named_at_the_end() {
    let mut pace = Pace::new(USUAL_BITRATE);
    for id in 0..16 {
        pace.frame((0, id, 8), 5).unwrap();
    }
    assert_eq!(pace.end().unwrap_err(), "16 frames of one instant, 5 us");
}

#[test]
fn a_bus_of_another_bitrate_carries_as_much_as_that() {
    let frames = |bitrate| {
        let mut pace = Pace::new(bitrate);
        (0..2000u64).try_for_each(|k| pace.frame((0, (k % 16) as u16, 8), k * 250))
    };
    assert_eq!(frames(USUAL_BITRATE), Ok(()));
    assert_eq!(frames(500_000), Ok(()));
    let refused = frames(250_000).unwrap_err();
    assert!(refused.contains("a bus of 250 kbit/s"), "{refused}");
}
