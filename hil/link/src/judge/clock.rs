//! A sender's clock on the receiver's: what is certain about their difference.
//!
//! Two facts bound it. What arrives was sent before, so `ours - theirs <= arrival - sent`. What the sender heard of us we had
//! said before, so `ours - theirs >= said - heard`. No delay is assumed to be the same in both directions. Crystals drift, so
//! both bounds give way with time.

use palpate_core::units::{Duration, Instant};

/// How far two clocks may run apart, microseconds per second: two poor crystals, or one that is being set.
const DRIFT: u64 = 500;

/// The two bounds contradict each other: one of the clocks was set, or stood still. Nothing is known any more.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Jumped;

/// Bounds of a sender's clock on ours.
#[derive(Clone, Debug, Default)]
pub struct Clock {
    /// Least of ours minus theirs, microseconds, and when that was learned.
    low: Option<(i64, Instant)>,
    /// Most of it.
    high: Option<(i64, Instant)>,
    /// What was said before this says nothing about the clocks as they are now.
    since: Instant,
}

/// By how much a bound of this age gives way, microseconds.
fn drift(since: Instant, now: Instant) -> i64 {
    let most = now.since(since).as_micros().saturating_mul(DRIFT);
    // Rounded to the unsafe side it would be no bound.
    signed(most.div_ceil(1_000_000))
}

/// A time that a peer states may be any number.
fn signed(micros: u64) -> i64 {
    i64::try_from(micros).unwrap_or(i64::MAX)
}

impl Clock {
    /// Something arrived at `now` that had been sent at `sent`, microseconds of the sender's.
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

    /// The sender had heard at `heard`, microseconds of its own, what we said at `said`.
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
            // Learned when it was said: the drift since then counts.
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

    /// The most time that may have passed since `theirs`, microseconds of the sender's; `None` until both have heard of
    /// each other.
    #[must_use]
    pub fn most_since(&self, theirs: u64, now: Instant) -> Option<Duration> {
        let (low, _) = self.bounds(now)?;
        let earliest = signed(theirs).saturating_add(low);
        let passed = signed(now.as_micros()).saturating_sub(earliest);
        Some(Duration::from_micros(u64::try_from(passed).unwrap_or(0)))
    }

    /// Between which offsets the truth lies: least and most of ours minus theirs, microseconds.
    #[must_use]
    pub fn offset(&self, now: Instant) -> Option<(i64, i64)> {
        self.bounds(now)
    }
}

#[cfg(test)]
#[path = "clock_tests.rs"]
mod tests;
