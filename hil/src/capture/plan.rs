//! What a schedule drives: bursts of every output, and the part of them that is asked about.

use std::collections::BTreeMap;

use palpate_records::trace::{Event, Trace};

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
    /// Whether a burst of these ends touches it.
    pub(super) fn touches(&self, from_ns: f64, to_ns: f64) -> bool {
        from_ns < self.to_ns && to_ns > self.from_ns
    }

    /// How much of it another one covers, seconds.
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
    /// Where in the period its pulses begin, ticks.
    pub(super) on: f64,
    /// Length of its pulses, ticks.
    pub(super) width: f64,
}

/// The bursts of every output, in the order of time.
pub(super) fn bursts(trace: &Trace) -> Plan {
    let mut found: Plan = Plan::new();
    let mut open: BTreeMap<Output, Burst> = BTreeMap::new();
    let mut close = |open: &mut BTreeMap<Output, Burst>, output: Output, at: f64| {
        if let Some(mut burst) = open.remove(&output) {
            burst.to_ns = burst.to_ns.min(at);
            found.entry(output).or_default().push(burst);
        }
    };
    for event in &trace.events {
        let at = event.t_ns() as f64;
        match event {
            Event::Schedule(entry) => {
                let output = (entry.board.0, entry.channel.0);
                close(&mut open, output, at);
                if entry.width().get() > 0 {
                    let burst = Burst {
                        from_ns: at,
                        to_ns: entry.until.as_micros() as f64 * 1e3,
                        on: f64::from(entry.on),
                        width: f64::from(entry.width().get()),
                    };
                    open.insert(output, burst);
                }
            }
            Event::AllOff(off) => {
                let on = |output: &Output| output.0 == off.board;
                let outputs: Vec<Output> = open.keys().copied().filter(on).collect();
                outputs.into_iter().for_each(|o| close(&mut open, o, at));
            }
            _ => {}
        }
    }
    for (output, burst) in open {
        found.entry(output).or_default().push(burst);
    }
    found
}

/// Whether another output of the board is driven at an instant, or was within the half period before: its counter
/// then runs, and a train begins with the counter's next period. Else it begins at once.
pub(super) fn is_busy(plan: &Plan, output: Output, at_ns: f64, period: f64) -> bool {
    plan.iter().any(|(other, bursts)| {
        let earlier = bursts.partition_point(|b| b.from_ns < at_ns);
        let last = earlier.checked_sub(1).and_then(|index| bursts.get(index));
        other.0 == output.0
            && *other != output
            && last.is_some_and(|b| b.to_ns + period / 2.0 > at_ns)
    })
}
