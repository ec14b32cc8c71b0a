//! Limits of rates.

use palpate_core::units::Instant;

/// A bucket of tokens: so many at once, and so many per second.
#[derive(Clone, Debug)]
pub struct Bucket {
    per_second: u64,
    most_us: u64,
    /// Tokens in the bucket, in microseconds' worth.
    held_us: u64,
    at: Instant,
}

impl Bucket {
    /// A full bucket.
    #[must_use]
    pub const fn new(per_second: u32, at_once: u32) -> Self {
        // A rate of nothing would be no rate.
        let per_second = if per_second == 0 {
            1
        } else {
            per_second as u64
        };
        let most_us = at_once as u64 * 1_000_000 / per_second;
        Self {
            per_second,
            most_us,
            held_us: most_us,
            at: Instant::ZERO,
        }
    }

    /// Takes a token; `false` where there is none.
    pub fn take(&mut self, now: Instant) -> bool {
        let passed = now.since(self.at).as_micros();
        self.at = self.at.max(now);
        self.held_us = self.held_us.saturating_add(passed).min(self.most_us);
        let one = 1_000_000 / self.per_second;
        let has = self.held_us >= one;
        if has {
            self.held_us -= one;
        }
        has
    }
}

#[cfg(test)]
#[path = "rate_tests.rs"]
mod tests;
