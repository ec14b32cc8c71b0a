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

/// Mean power over a window.
#[derive(Clone, Copy, Debug)]
pub(super) struct Window {
    pub(super) length: Duration,
    pub(super) mean_uw: u64,
}

impl Window {
    /// Energy that fits in.
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

    /// Energy in nanojoules that may be spent at `at`. A time in the past counts as now.
    pub(super) fn left_nj(&mut self, at: Instant) -> u64 {
        let passed = at.since(self.at).as_micros();
        self.at = self.at.max(at);
        let refill = self.rate_uw.saturating_mul(passed);
        self.left_pj = self.left_pj.saturating_add(refill).min(self.capacity_pj);
        self.left_pj / 1000
    }

    /// Books energy, at most what is left.
    pub(super) fn spend(&mut self, nj: u64) {
        self.left_pj = self.left_pj.saturating_sub(nj.saturating_mul(1000));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::Stream;
    use alloc::vec::Vec;

    const S: u64 = 1_000_000;

    fn bucket(short_uw: u64, long_uw: u64, long_s: u64) -> Bucket {
        let window = |s: u64, mean_uw| Window {
            length: Duration::from_micros(s * S),
            mean_uw,
        };
        let reach = Duration::from_millis(50);
        Bucket::new(window(1, short_uw), window(long_s, long_uw), reach)
    }

    #[test]
    fn no_window_is_ever_passed_by_spending_greedily_at_random_times() {
        for (short, long, long_s) in [
            (45_000, 20_000, 10),
            (110_000, 60_000, 60),
            (5, 20_000, 10),
            (45_000, 100, 10),
        ] {
            let mut bucket = bucket(short, long, long_s);
            let mut stream = Stream::new(3, "bucket");
            let (mut now, mut spent): (u64, Vec<(u64, u64)>) = (0, Vec::new());
            for _ in 0..6_000 {
                now += stream.next_u64()
                    % if stream.next_u64().is_multiple_of(40) {
                        9 * S
                    } else {
                        80_000
                    };
                let left = bucket.left_nj(Instant::from_micros(now));
                let take = if stream.uniform() < 0.5 {
                    left
                } else {
                    left / 3
                };
                bucket.spend(take);
                spent.push((now, take));
                for (window, uw) in [(S, short), (long_s * S, long)] {
                    let since = now.saturating_sub(window + 50_000);
                    let sum: u64 = spent
                        .iter()
                        .rev()
                        .take_while(|(t, _)| *t >= since)
                        .map(|(_, e)| e)
                        .sum();
                    assert!(
                        sum * 1000 <= uw * window,
                        "{sum} nJ over {window} us at {now} us"
                    );
                }
            }
        }
    }

    #[test]
    fn the_rest_of_the_budget_is_there_to_be_used() {
        // 45 mJ over 1 s and 200 mJ over 10 s: r = 155 / 9 = 17.2 mW, C = 45 - 1.05 r = 26.9 mJ.
        let mut wire = bucket(45_000, 20_000, 10);
        assert_eq!(wire.left_nj(Instant::ZERO) / 100_000, 269);
        wire.spend(u64::MAX);
        assert_eq!(wire.left_nj(Instant::ZERO), 0);
        assert_eq!(wire.left_nj(Instant::from_micros(S)) / 100_000, 172);
        assert_eq!(wire.left_nj(Instant::from_micros(10)) / 100_000, 172);
        assert_eq!(wire.left_nj(Instant::FAR_FUTURE) / 100_000, 269);
    }
}
