//! Tests of `errors.rs`.

use super::*;

#[test]
fn bus_off_and_the_way_back_are_seen() {
    let mut tally = Tally::default();
    assert_eq!(tally.error(0x40, [0; 8]), Some(Change::BusOff));
    assert_eq!(tally.error(0x100, [0; 8]), Some(Change::Restarted));
    let passive = [0, 0x20, 0, 0, 0, 0, 0, 0];
    assert_eq!(tally.error(0x04, passive), Some(Change::Passive));
    assert_eq!(tally.error(0x88, [0; 8]), None); // protocol and bus error in one frame
    let overrun = [0, 0x01, 0, 0, 0, 0, 0, 0];
    assert_eq!(tally.error(0x04, overrun), None);
    assert_eq!(tally.error(0x00, overrun), None); // data of another class
    let expected = Tally {
        bus_errors: 1,
        overruns: 1,
        bus_off: 1,
        restarts: 1,
        ..Tally::default()
    };
    assert_eq!(tally, expected);
}

#[test]
fn the_count_of_lost_frames_wraps() {
    let (mut tally, mut last) = (Tally::default(), u32::MAX - 1);
    assert_eq!(tally.drops(&mut last, 3), 5);
    assert_eq!(tally.drops(&mut last, 3), 0);
    assert_eq!(tally.dropped, 5);
}
