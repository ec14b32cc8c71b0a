//! Tests of `messages.rs`.

use super::*;
use crate::mcap::proto::Message;

/// Seven pulses of 5.079040 ms from 20 us on, 5 ticks wide.
fn line(of_the_end: impl FnOnce(&mut Message)) -> Option<bool> {
    let mut message = Message::default();
    message
        .uint(3, 5_u64)
        .uint(4, 5_u64)
        .uint(6, 5_u64)
        .uint(7, 35_020_u64)
        .text(8, "burst");
    of_the_end(&mut message);
    agrees(20_000, message.bytes())
}

#[test]
fn pulses_of_a_line_follow_from_its_times_or_it_has_none() {
    let with = |pulses: u64, period: u64| {
        line(|m| {
            m.uint(9, pulses).uint(10, period);
        })
    };
    assert_eq!(with(7, 5_079_040), Some(true));
    assert_eq!(with(0, 0), Some(true), "an older file");
    for (pulses, period) in [(8, 5_079_040), (0, 5_079_040), (7, 0)] {
        assert_eq!(with(pulses, period), Some(false), "{pulses}, {period}");
    }
    let none = |field, value: u64| {
        line(|m| {
            m.uint(field, value);
        })
    };
    assert_eq!(none(6, 4097), None);
    assert_eq!(none(11, 70_000), Some(true), "cut by the guard");
    assert_eq!(none(11, 35_019), None);
    assert_eq!(none(5, 1 << 20), None);
    let tea = line(|m| {
        m.text(8, "tea");
    });
    assert_eq!(tea, None);
}
