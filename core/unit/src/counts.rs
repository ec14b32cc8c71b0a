//! What a unit counts and reports.

use palpate_core::schedule::{Entry, Reason};

/// Counters since the start; each stays at its end.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Counts {
    pub(crate) applied: u32,
    pub(crate) limited: u32,
    pub(crate) reasons: u16,
    pub(crate) dropped: u32,
    pub(crate) late_us: u32,
    pub(crate) refused: u32,
    pub(crate) stops: u32,
}

impl Counts {
    /// A stimulus that the guard has judged.
    pub(crate) fn judged(&mut self, entry: &Entry) {
        self.applied = self.applied.saturating_add(1);
        if let Some(reason) = entry.reason {
            self.limited = self.limited.saturating_add(1);
            let bit = Reason::ALL.iter().position(|r| *r == reason);
            self.reasons |= bit.map_or(0, |bit| 1 << bit);
        }
    }
}
