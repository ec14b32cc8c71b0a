//! Bursts of the wires, start to end, put back together from the schedule's entries.

use crate::trace::{Event, Header, Trace, WireInfo};
use palpate_core::schedule::{Entry, Reason};
use std::collections::{BTreeMap, BTreeSet};
use std::fmt;

/// Output that is driven: a wire of the display, or an output without a wire.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum DrivenOutput {
    /// A wire, by its index in the display's layout.
    Wire(u16),
    /// An output without a wire, by board and channel.
    Pin(u8, u8),
}

impl fmt::Display for DrivenOutput {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Wire(wire) => write!(out, "wire {wire}"),
            Self::Pin(board, channel) => write!(out, "output {board}:{channel}"),
        }
    }
}

/// One stay of an output: on at a width, or held off although something was asked for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Burst {
    /// Output that is driven.
    pub output: DrivenOutput,
    /// Start, microseconds.
    pub from_us: u64,
    /// End, microseconds: the end asked for, the next entry of the channel or an all-off.
    pub to_us: u64,
    /// Width applied, ticks; 0 is a refusal.
    pub width: u16,
    /// Width asked for, ticks.
    pub requested: u16,
    /// Reason for which the two widths differ.
    pub reason: Option<Reason>,
}

impl Burst {
    /// The wire that is driven, if one is.
    pub const fn wire(&self) -> Option<u16> {
        match self.output {
            DrivenOutput::Wire(wire) => Some(wire),
            DrivenOutput::Pin(..) => None,
        }
    }
}

/// Output that a channel of a board drives.
fn output(header: &Header, board: u8, channel: u8) -> DrivenOutput {
    let drives = |w: &WireInfo| w.board == board && w.channel == channel;
    let index = header.wires.iter().position(drives);
    match index.map(u16::try_from) {
        Some(Ok(wire)) => DrivenOutput::Wire(wire),
        _ => DrivenOutput::Pin(board, channel),
    }
}

/// Every entry that wants an output on, with the end of its stay, microseconds: the end asked for, the next entry of the
/// channel or an all-off. Those of one output are in the order of time.
pub fn stays(trace: &Trace) -> Vec<(&Entry, u64)> {
    let mut open: BTreeMap<(u8, u8), &Entry> = BTreeMap::new();
    let mut done = Vec::new();
    let end = |entry: &Entry, now_us: u64| {
        let end_us = entry.until.as_micros().min(now_us);
        end_us.max(entry.at.as_micros())
    };
    for event in &trace.events {
        match event {
            Event::Schedule(entry) => {
                let key = (entry.board.0, entry.channel.0);
                if let Some(before) = open.remove(&key) {
                    done.push((before, end(before, entry.at.as_micros())));
                }
                if entry.width().get() > 0 || entry.requested.get() > 0 {
                    open.insert(key, entry);
                }
            }
            Event::AllOff(off) => {
                let keys: Vec<_> = open.keys().filter(|k| k.0 == off.board).copied().collect();
                for key in keys {
                    if let Some(before) = open.remove(&key) {
                        done.push((before, end(before, off.t_us)));
                    }
                }
            }
            _ => {}
        }
    }
    let left = open.into_values();
    done.extend(left.map(|entry| (entry, end(entry, u64::MAX))));
    done
}

/// Every burst of a run, sorted by start and output. Entries that only switch an output off
/// end a burst and are none themselves.
pub fn bursts(trace: &Trace) -> Vec<Burst> {
    let burst = |(entry, to_us): (&Entry, u64)| Burst {
        output: output(&trace.header, entry.board.0, entry.channel.0),
        from_us: entry.at.as_micros(),
        to_us,
        width: entry.width().get(),
        requested: entry.requested.get(),
        reason: entry.reason,
    };
    let mut all: Vec<Burst> = stays(trace).into_iter().map(burst).collect();
    all.sort_by_key(|b| (b.from_us, b.output));
    all
}

/// All wires of a small display; of one with more than `most`, the first `most` that were driven.
pub fn shown_wires(trace: &Trace, all: &[Burst], most: usize) -> Vec<u16> {
    let count = u16::try_from(trace.header.wires.len()).unwrap_or(u16::MAX);
    if usize::from(count) <= most {
        return (0..count).collect();
    }
    let driven: BTreeSet<u16> = all.iter().filter_map(Burst::wire).collect();
    driven.into_iter().take(most).collect()
}

#[cfg(test)]
#[path = "bursts_tests.rs"]
mod tests;
