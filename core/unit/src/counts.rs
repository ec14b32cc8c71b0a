//! Counters that a unit keeps and reports.

use palpate_core::schedule::{Entry, Reason};

/// Counters since the start; each stays at its end.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counts {
    /// Stimuli begun.
    pub applied: u32,
    /// Begun stimuli that the guard changed or refused.
    pub limited: u32,
    /// Reasons of the guard for those, a bit for each of [`Reason::ALL`].
    pub reasons: u16,
    /// Stimuli left out: too late, after too old a reading, while stopped, without a wire.
    pub dropped: u32,
    /// The latest beginning of this session after its time, microseconds.
    pub late_us: u32,
    /// Datagrams refused.
    pub refused: u32,
    /// Stops.
    pub stops: u32,
    /// Sessions begun.
    pub sessions: u32,
}

impl Counts {
    /// Counts a stimulus that the guard has judged.
    pub(crate) fn judged(&mut self, entry: &Entry) {
        self.applied = self.applied.saturating_add(1);
        if let Some(reason) = entry.reason {
            self.limited = self.limited.saturating_add(1);
            let bit = Reason::ALL.iter().position(|r| *r == reason);
            self.reasons |= bit.map_or(0, |bit| 1 << bit);
        }
    }
}
