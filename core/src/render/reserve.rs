//! Energy that a wire may spend: a bucket that fills at the power it can bear for a whole session.
//!
//! The guard lets a wire have more for ten seconds than for ten minutes. A contact that rests shall not fade for that long,
//! so it is held to the power of the long run from the start.

use crate::units::{Duration, Instant};

/// Time for which the power that fills a reserve could flow.
pub(super) const SESSION: Duration = Duration::from_millis(600_000);
/// A full reserve, nJ: what the guard's bucket of a wire has to spend at once, about.
const FULL_NJ: f32 = 25e6;

/// The part of that power that fills a reserve. The guard's mean over 10 s counts up to a bin of 0.25 s too much, and what
/// is left has to stay larger than a burst: with less of a margin the level would beat with the bins.
pub(super) const PART: f32 = 0.93;

/// Energy that a wire may spend.
#[derive(Clone, Copy, Debug)]
pub(super) struct Reserve {
    left_nj: f32,
    rate_uw: f32,
    at: Instant,
}

impl Reserve {
    /// A full reserve for a wire that can bear this power, uW.
    pub(super) fn new(sustained_uw: u64) -> Self {
        Self {
            left_nj: FULL_NJ,
            rate_uw: PART * sustained_uw as f32,
            at: Instant::ZERO,
        }
    }

    /// Energy left at `at`, nJ.
    pub(super) fn left_nj(&self, at: Instant) -> f32 {
        let filled = self.rate_uw * at.since(self.at).as_micros() as f32 * 1e-3;
        (self.left_nj + filled).min(FULL_NJ)
    }

    /// Takes the booking of a burst at `at`, nJ.
    pub(super) fn spend(&mut self, at: Instant, energy_nj: u64) {
        self.left_nj = (self.left_nj(at) - energy_nj as f32).max(0.0);
        self.at = at;
    }
}
