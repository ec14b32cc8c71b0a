//! A sender's clock on the receiver's: certain bounds of their difference.
//!
//! Two facts bound it. A frame was sent before it arrived, so `ours - theirs <= arrival - sent`. A message of ours was
//! sent before the sender heard it, so `ours - theirs >= said - heard`. No delay is assumed to be the same in both
//! directions. Crystals drift, so both bounds give way with time.

use palpate_core::units::{Duration, Instant};

/// Largest drift between two clocks, microseconds per second: two poor crystals, or one that is being set.
const DRIFT: u64 = 500;

/// Error of bounds that contradict each other: one of the clocks was set, or stood still. Nothing is known any more.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Jumped;

/// Bounds of a sender's clock on ours.
#[derive(Clone, Debug, Default)]
pub struct Clock {
    /// Least of ours minus theirs, microseconds, and when that was learned.
    low: Option<(i64, Instant)>,
    /// Most of ours minus theirs, microseconds, and when that was learned.
    high: Option<(i64, Instant)>,
    /// Time of the newest start: messages from before it tell nothing about the clocks as they are now.
    since: Instant,
}

/// Loosening of a bound of this age, microseconds.
fn drift(since: Instant, now: Instant) -> i64 {
    let most = now.since(since).as_micros().saturating_mul(DRIFT);
    // Rounded the other way it would be no bound.
    signed(most.div_ceil(1_000_000))
}

/// A time that a peer states may be any number.
fn signed(micros: u64) -> i64 {
    i64::try_from(micros).unwrap_or(i64::MAX)
}

impl Clock {
    /// Takes a message that arrived at `now` and was sent at `sent`, microseconds of the sender's clock.
    ///
    /// # Errors
    /// [`Jumped`]; the clock starts anew.
    pub fn arrived(&mut self, sent: u64, now: Instant) -> Result<(), Jumped> {
        let bound = signed(now.as_micros()).saturating_sub(signed(sent));
        let older = self
            .high
            .map(|(high, at)| high.saturating_add(drift(at, now)));
        if older.is_none_or(|older| bound <= older) {
            self.high = Some((bound, now));
        }
        self.check(now)
    }

    /// Takes an echo: the sender had heard at `heard`, microseconds of its own clock, our message of `said`.
    ///
    /// # Errors
    /// [`Jumped`]; the clock starts anew.
    pub fn echoed(&mut self, said: Instant, heard: u64, now: Instant) -> Result<(), Jumped> {
        if said < self.since || said > now {
            return Ok(());
        }
        let bound = signed(said.as_micros()).saturating_sub(signed(heard));
        let older = self.low.map(|(low, at)| low.saturating_sub(drift(at, now)));
        if older.is_none_or(|older| bound >= older) {
            // Learned at the time of our message: the drift since then counts.
            self.low = Some((bound, said));
        }
        self.check(now)
    }

    fn check(&mut self, now: Instant) -> Result<(), Jumped> {
        match self.bounds(now) {
            Some((low, high)) if low > high => {
                *self = Self {
                    since: now,
                    ..Self::default()
                };
                Err(Jumped)
            }
            _ => Ok(()),
        }
    }

    fn bounds(&self, now: Instant) -> Option<(i64, i64)> {
        let (low, low_at) = self.low?;
        let (high, high_at) = self.high?;
        let low = low.saturating_sub(drift(low_at, now));
        Some((low, high.saturating_add(drift(high_at, now))))
    }

    /// Longest time that may have passed since `theirs`, microseconds of the sender's; `None` until both have heard of
    /// each other.
    #[must_use]
    pub fn most_since(&self, theirs: u64, now: Instant) -> Option<Duration> {
        let (low, _) = self.bounds(now)?;
        let earliest = signed(theirs).saturating_add(low);
        let passed = signed(now.as_micros()).saturating_sub(earliest);
        Some(Duration::from_micros(u64::try_from(passed).unwrap_or(0)))
    }

    /// Bounds of the true offset: least and most of ours minus theirs, microseconds.
    #[must_use]
    pub fn offset(&self, now: Instant) -> Option<(i64, i64)> {
        self.bounds(now)
    }
}

#[cfg(test)]
#[path = "clock_tests.rs"]
mod tests;
