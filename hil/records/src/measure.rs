//! Errors and tallies of a trace, all in integers.

use crate::bursts::bursts;
use crate::fixed::distance2_um;
use crate::trace::{Event, PlaceUm, Trace, event};
use palpate_core::units::Ticks;
use std::collections::BTreeMap;

/// Distances of measured places from wanted ones.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Errors {
    /// Root of the mean square, micrometres, rounded down.
    pub rmse_um: u64,
    /// The largest, micrometres, rounded down.
    pub max_um: u64,
    /// Number of measured distances.
    pub count: u64,
}

/// Collects squared distances.
#[derive(Debug, Default)]
pub(crate) struct Sum {
    squares: u128,
    max: u64,
    count: u64,
}

impl Sum {
    pub(crate) fn add(&mut self, squared_um: u64) {
        self.squares = self.squares.saturating_add(u128::from(squared_um));
        self.max = self.max.max(squared_um);
        self.count += 1;
    }

    pub(crate) fn errors(&self) -> Option<Errors> {
        let mean = self.squares.checked_div(u128::from(self.count))?;
        Some(Errors {
            rmse_um: u64::try_from(mean).unwrap_or(u64::MAX).isqrt(),
            max_um: self.max.isqrt(),
            count: self.count,
        })
    }
}

/// Contact path against the true path, sensor space: for each truth the nearest contact of the same
/// scan. `None` where no truth met a contact.
pub fn path_error(trace: &Trace) -> Option<Errors> {
    let mut contacts: BTreeMap<u64, Vec<PlaceUm>> = BTreeMap::new();
    for contact in trace.each::<event::Contact>() {
        let now = contacts.entry(contact.t_us).or_default();
        now.push(contact.place);
    }
    let mut sum = Sum::default();
    for truth in trace.each::<event::Truth>() {
        let now = contacts.get(&truth.t_us).into_iter().flatten();
        let nearest = now.map(|p| distance2_um(*p, truth.place)).min();
        nearest.into_iter().for_each(|squared| sum.add(squared));
    }
    sum.errors()
}

/// Length of the run, microseconds: what the ledger says, or the last event where it says nothing.
pub fn length_us(trace: &Trace) -> u64 {
    if trace.ledger.length_us > 0 {
        return trace.ledger.length_us;
    }
    let last = trace.events.iter().map(|e| e.t_ns() / 1000).max();
    last.unwrap_or(0)
}

/// Tally of one wire.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct WireTally {
    /// Bursts with a width above zero.
    pub bursts: u64,
    /// Bursts in which something else than the request was applied, refusals among them.
    pub limited: u64,
    /// Time within bursts, microseconds.
    pub burst_us: u64,
    /// Time the pulses of those bursts were high, nanoseconds (the share of the period, not edges).
    pub high_ns: u64,
    /// Widest pulse, ticks.
    pub widest: u16,
    /// Hottest sample, thousandths of a degree Celsius.
    pub hottest_milli_c: Option<i32>,
}

/// One tally a wire of the display, in its order.
pub fn wire_tallies(trace: &Trace) -> Vec<WireTally> {
    let mut tallies = vec![WireTally::default(); trace.header.wires.len()];
    for burst in bursts(trace) {
        let Some(tally) = burst.wire().and_then(|w| tallies.get_mut(usize::from(w))) else {
            continue;
        };
        tally.limited += u64::from(burst.reason.is_some());
        if burst.width == 0 {
            continue;
        }
        let span = burst.to_us - burst.from_us;
        tally.bursts += 1;
        tally.burst_us = tally.burst_us.saturating_add(span);
        let high =
            u128::from(span) * 1000 * u128::from(burst.width) / u128::from(Ticks::PER_PERIOD);
        let high = u64::try_from(high).unwrap_or(u64::MAX);
        tally.high_ns = tally.high_ns.saturating_add(high);
        tally.widest = tally.widest.max(burst.width);
    }
    for event in &trace.events {
        if let Event::Wire(now) = event
            && let Some(tally) = tallies.get_mut(usize::from(now.wire))
        {
            tally.hottest_milli_c = tally.hottest_milli_c.max(Some(now.milli_c));
        }
    }
    tallies
}

#[cfg(test)]
#[path = "measure_tests.rs"]
mod tests;
