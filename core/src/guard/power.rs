//! Mean power over two windows at once, from above, in a few bytes: a token bucket.
//!
//! A bucket of capacity C that refills at rate r lets through at most C + r W in any window W. C and r
//! are chosen so that this meets the limits of both windows, with the reach of one burst added: a burst
//! is booked at its onset and may reach into a window that opens after it. A contact that rests empties
//! the bucket and then lives on the refill: it fades to a steady level and is never cut off.

use crate::units::{Duration, Instant};

/// Energy that may still be spent; picojoules, which are microwatts times microseconds.
#[derive(Clone, Debug)]
pub(super) struct Bucket {
    capacity_pj: u64,
    rate_uw: u64,
    left_pj: u64,
    at: Instant,
}

/// Energy that was spent of what a bucket holds.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Spent {
    /// Energy, picojoules; more than there is counts as all of it.
    pub pj: u64,
    /// Time since then: what refills in it is no longer spent.
    pub ago: Duration,
}

impl Spent {
    /// All energy of a bucket, spent now.
    pub(super) const ALL: Self = Self {
        pj: u64::MAX,
        ago: Duration::ZERO,
    };
}

/// Mean power over a window.
#[derive(Clone, Copy, Debug)]
pub(super) struct Window {
    pub(super) length: Duration,
    pub(super) mean_uw: u64,
}

impl Window {
    /// Energy that fits in the window, pJ.
    const fn energy_pj(self) -> u64 {
        self.mean_uw.saturating_mul(self.length.as_micros())
    }
}

impl Bucket {
    /// A full bucket that keeps both windows, the second the longer one, for bursts that end `reach` after
    /// they are booked.
    ///
    /// C + r (T1 + b) = E1 and C + r (T2 + b) = E2; where a tightened table would make C negative or r
    /// vanish, half of either energy goes to each.
    pub(super) fn new(short: Window, long: Window, reach: Duration) -> Self {
        let reach_us = |w: Window| w.length.as_micros() + reach.as_micros();
        let (e1, e2) = (short.energy_pj(), long.energy_pj());
        let e1 = e1.min(e2 / 2);
        let between = (long.length.as_micros() - short.length.as_micros()).max(1);
        let rate_uw = ((e2 - e1) / between).min(e1 / 2 / reach_us(short));
        let used = |w: Window| rate_uw * reach_us(w);
        // The division above rounds down, so the long window is checked too.
        let capacity_pj = (e1 - used(short)).min(e2.saturating_sub(used(long)));
        Self {
            capacity_pj,
            rate_uw,
            left_pj: capacity_pj,
            at: Instant::ZERO,
        }
    }

    /// Power that may flow for ever, uW.
    pub(super) const fn rate_uw(&self) -> u64 {
        self.rate_uw
    }

    /// Energy in nanojoules that may be spent at `at`. A time in the past counts as now.
    pub(super) fn left_nj(&mut self, at: Instant) -> u64 {
        self.left_pj = self.left_pj_at(at);
        self.at = self.at.max(at);
        self.left_pj / 1000
    }

    /// Energy that may be spent at `at`, pJ; the bucket stays unchanged.
    pub(super) fn left_pj_at(&self, at: Instant) -> u64 {
        let refill = self.rate_uw.saturating_mul(at.since(self.at).as_micros());
        self.left_pj.saturating_add(refill).min(self.capacity_pj)
    }

    /// The most, nanojoules, that may be booked in a span from `at` on.
    pub(super) fn most_nj(&self, at: Instant, span: Duration) -> u64 {
        let refill = self.rate_uw.saturating_mul(span.as_micros());
        self.left_pj_at(at).saturating_add(refill) / 1000
    }

    /// The share of the bucket that is spent at `at`; all of an empty capacity.
    pub(super) fn used_at(&self, at: Instant) -> f64 {
        match self.capacity_pj {
            0 => 1.0,
            capacity => 1.0 - self.left_pj_at(at) as f64 / capacity as f64,
        }
    }

    /// Energy spent as of `at`.
    pub(super) fn spent(&self, at: Instant) -> Spent {
        Spent {
            pj: self.capacity_pj - self.left_pj_at(at),
            ago: Duration::ZERO,
        }
    }

    /// Resumes at `at` from the energy that was spent before.
    pub(super) fn recall(&mut self, spent: &Spent, at: Instant) {
        let refill = self.rate_uw.saturating_mul(spent.ago.as_micros());
        let left = self.capacity_pj.saturating_sub(spent.pj);
        self.left_pj = left.saturating_add(refill).min(self.capacity_pj);
        self.at = at;
    }

    /// Books energy, at most what is left.
    pub(super) fn spend(&mut self, nj: u64) {
        self.left_pj = self.left_pj.saturating_sub(nj.saturating_mul(1000));
    }
}

#[cfg(test)]
#[path = "power_tests.rs"]
mod tests;
