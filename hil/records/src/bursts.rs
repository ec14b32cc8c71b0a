//! Which wire was on from when to when: the schedule's entries put back together into bursts.

use crate::trace::{Event, Header, Trace};
use palpate_core::schedule::{Entry, Reason};
use std::collections::{BTreeMap, BTreeSet};

/// One stay of a wire: on at a width, or held off although something was asked for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Burst {
    /// Wire index in the display's layout; `None` when the output drives no wire of it.
    pub wire: Option<u16>,
    /// Board and channel of the output.
    pub output: (u8, u8),
    /// Start, microseconds.
    pub from_us: u64,
    /// End, microseconds: the end asked for, the next entry of the channel or an all-off.
    pub to_us: u64,
    /// Width applied, ticks; 0 is a refusal.
    pub width: u16,
    /// Width asked for, ticks.
    pub requested: u16,
    /// Why they differ.
    pub reason: Option<Reason>,
}

/// Wire that an output drives.
pub fn wire_of(header: &Header, board: u8, channel: u8) -> Option<u16> {
    let index = header
        .wires
        .iter()
        .position(|w| w.board == board && w.channel == channel)?;
    u16::try_from(index).ok()
}

/// Every burst of a run, sorted by start, board and channel. Entries that only switch an output off
/// end a burst and are none themselves.
pub fn bursts(trace: &Trace) -> Vec<Burst> {
    let mut open: BTreeMap<(u8, u8), Burst> = BTreeMap::new();
    let mut done = Vec::new();
    for event in &trace.events {
        match event {
            Event::Schedule(entry) => {
                let key = (entry.board.0, entry.channel.0);
                if let Some(before) = open.remove(&key) {
                    close(&mut done, before, entry.at.as_micros());
                }
                if entry.width().get() > 0 || entry.requested.get() > 0 {
                    open.insert(key, start(&trace.header, entry));
                }
            }
            Event::AllOff { t_us, board, .. } => {
                let keys: Vec<_> = open.keys().filter(|k| k.0 == *board).copied().collect();
                for key in keys {
                    if let Some(before) = open.remove(&key) {
                        close(&mut done, before, *t_us);
                    }
                }
            }
            _ => {}
        }
    }
    done.extend(open.into_values());
    done.sort_by_key(|b| (b.from_us, b.output));
    done
}

fn start(header: &Header, entry: &Entry) -> Burst {
    Burst {
        wire: wire_of(header, entry.board.0, entry.channel.0),
        output: (entry.board.0, entry.channel.0),
        from_us: entry.at.as_micros(),
        to_us: entry.until.as_micros().max(entry.at.as_micros()),
        width: entry.width().get(),
        requested: entry.requested.get(),
        reason: entry.reason,
    }
}

fn close(done: &mut Vec<Burst>, mut burst: Burst, now_us: u64) {
    burst.to_us = burst.to_us.min(now_us.max(burst.from_us));
    done.push(burst);
}

/// All wires of a small display; of one with more than `most`, the first `most` that were driven.
pub fn shown_wires(trace: &Trace, all: &[Burst], most: usize) -> Vec<u16> {
    let count = u16::try_from(trace.header.wires.len()).unwrap_or(u16::MAX);
    if usize::from(count) <= most {
        return (0..count).collect();
    }
    let driven: BTreeSet<u16> = all.iter().filter_map(|b| b.wire).collect();
    driven.into_iter().take(most).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::synthetic;
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
            Event::AllOff {
                t_us: 70_000,
                board: 0,
                cause: "stale-input",
            },
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
}
