//! Plan of a schedule: bursts of every output, and the part of them that is asked about.

use std::collections::BTreeMap;

use palpate_records::bursts::stays;
use palpate_records::trace::Trace;

/// Board and channel.
pub type Output = (u8, u8);

/// The bursts of every output that is driven.
pub(super) type Plan = BTreeMap<Output, Vec<Burst>>;

/// A part of the run, nanoseconds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Span {
    pub(super) from_ns: f64,
    pub(super) to_ns: f64,
}

impl Span {
    /// Tells whether a burst of these ends touches the span.
    pub(super) fn touches(&self, from_ns: f64, to_ns: f64) -> bool {
        from_ns < self.to_ns && to_ns > self.from_ns
    }

    /// Overlap with another span, seconds.
    pub(super) fn overlap_s(&self, other: &Self) -> f64 {
        let (from, to) = (self.from_ns.max(other.from_ns), self.to_ns.min(other.to_ns));
        (to - from).max(0.0) * 1e-9
    }
}

/// Bursts that follow one another without a pause: the chip sees one pulse train that changes its width.
pub(super) fn chains(bursts: &[Burst]) -> impl Iterator<Item = &[Burst]> {
    bursts.chunk_by(|a, b| a.to_ns >= b.from_ns)
}

/// A channel's pulse train, as scheduled.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Burst {
    /// Start, nanoseconds of the run.
    pub(super) from_ns: f64,
    /// End: its own, or the next record that concerns the channel.
    pub(super) to_ns: f64,
    /// Start of its pulses in the period, ticks.
    pub(super) on: f64,
    /// Length of its pulses, ticks.
    pub(super) width: f64,
}

/// The bursts of every output, in the order of time.
pub(super) fn bursts(trace: &Trace) -> Plan {
    let mut plan = Plan::new();
    for (entry, to_us) in stays(trace) {
        let width = entry.width().get();
        if width > 0 {
            let output = (entry.board.0, entry.channel.0);
            plan.entry(output).or_default().push(Burst {
                from_ns: entry.at.as_micros() as f64 * 1e3,
                to_ns: to_us as f64 * 1e3,
                on: f64::from(entry.on),
                width: f64::from(width),
            });
        }
    }
    plan
}

/// Tells whether another output of the board is driven at an instant, or was within the half period before. If so, the
/// board's counter runs, and a train begins with its next period; else a train begins at once.
pub(super) fn is_busy(plan: &Plan, output: Output, at_ns: f64, period: f64) -> bool {
    plan.iter().any(|(other, bursts)| {
        let earlier = bursts.partition_point(|b| b.from_ns < at_ns);
        let last = earlier.checked_sub(1).and_then(|index| bursts.get(index));
        other.0 == output.0
            && *other != output
            && last.is_some_and(|b| b.to_ns + period / 2.0 > at_ns)
    })
}
