//! Tests of `bursts.rs`.

use super::*;
use crate::synthetic;
use crate::trace::event;
use palpate_core::units::{Board, Channel, Instant, Ticks};

fn entry(at: u64, until: u64, width: u16) -> Event {
    Event::Schedule(Entry {
        at: Instant::from_micros(at),
        board: Board(0),
        channel: Channel(1),
        on: 256,
        off: 256 + width,
        until: Instant::from_micros(until),
        requested: Ticks::new(width),
        requested_until: Instant::from_micros(until),
        current: None,
        reason: None,
    })
}

#[test]
fn a_burst_ends_at_the_first_of_until_next_entry_and_all_off() {
    let mut trace = synthetic::empty();
    trace.events = vec![
        entry(0, 35_000, 100),
        entry(35_000, 35_000, 0),
        entry(58_500, 93_500, 90),
        entry(60_000, 95_000, 80),
        Event::AllOff(event::AllOff {
            t_us: 70_000,
            board: 0,
            cause: "stale-input",
        }),
        entry(200_000, 235_000, 70),
    ];
    let ends: Vec<_> = bursts(&trace)
        .iter()
        .map(|b| (b.from_us, b.to_us, b.width))
        .collect();
    assert_eq!(
        ends,
        [
            (0, 35_000, 100),
            (58_500, 60_000, 90),
            (60_000, 70_000, 80),
            (200_000, 235_000, 70)
        ]
    );
}
