//! Mean power over sliding windows, from above, in fixed memory.
//!
//! Energy is booked in buckets of 50 ms. A burst is booked whole into the bucket of its end, and a
//! window is read as every bucket it touches. So a window never misses energy: it sees up to one bucket
//! too much (5 % of the 1 s window), never too little.

use alloc::boxed::Box;
use alloc::vec;

use crate::units::Instant;

const BUCKET_US: u64 = 50_000;

/// Energy over two sliding windows.
#[derive(Clone, Debug)]
pub(super) struct Windows {
    /// Energy by bucket, nanojoules, a ring over the longest window.
    ring: Box<[u64]>,
    /// Buckets of the short window.
    short: usize,
    /// Bucket number of the newest entry.
    head: u64,
    /// Energy in the short and in the long window that end with the newest bucket, nanojoules.
    sums: (u64, u64),
}

impl Windows {
    /// Windows of `short_s` and `long_s` seconds; the second is the longer one.
    pub(super) fn new(short_s: usize, long_s: usize) -> Self {
        // One bucket more than the window is long: it touches one partly at each end.
        let buckets = |s: usize| s * 1_000_000 / BUCKET_US as usize + 1;
        Self {
            ring: vec![0; buckets(long_s)].into(),
            short: buckets(short_s),
            head: 0,
            sums: (0, 0),
        }
    }

    /// Moves the newest bucket to the one that holds `t`; earlier times leave it where it is.
    fn advance(&mut self, t: Instant) {
        let target = t.as_micros() / BUCKET_US;
        if target.saturating_sub(self.head) >= self.ring.len() as u64 {
            self.ring.fill(0);
            self.sums = (0, 0);
            self.head = target;
        }
        let n = self.ring.len() as u64;
        while self.head < target {
            self.head += 1;
            let slot = (self.head % n) as usize;
            self.sums.1 -= self.ring[slot];
            self.ring[slot] = 0;
            // The bucket that has just left the short window is still in the ring: that is longer.
            if let Some(left) = self.head.checked_sub(self.short as u64) {
                self.sums.0 -= self.ring[(left % n) as usize];
            }
        }
    }

    /// Energy in nanojoules that may still be booked at `t` before the short window holds `short_nj`
    /// or the long one `long_nj`.
    pub(super) fn room(&mut self, t: Instant, short_nj: u64, long_nj: u64) -> u64 {
        self.advance(t);
        short_nj
            .saturating_sub(self.sums.0)
            .min(long_nj.saturating_sub(self.sums.1))
    }

    /// Books energy spent up to `t`.
    pub(super) fn book(&mut self, t: Instant, nj: u64) {
        self.advance(t);
        let slot = (self.head % self.ring.len() as u64) as usize;
        self.ring[slot] += nj;
        self.sums.0 += nj;
        self.sums.1 += nj;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use alloc::vec::Vec;

    fn at(ms: u64) -> Instant {
        Instant::from_micros(ms * 1000)
    }

    #[test]
    fn agrees_with_a_sum_over_all_that_was_booked() {
        let mut windows = Windows::new(1, 10);
        let mut log: Vec<(u64, u64)> = Vec::new();
        let mut stream = crate::random::Stream::new(3, "windows");
        let mut now = 0u64;
        for _ in 0..20_000 {
            now += stream.next_u64()
                % if stream.next_u64().is_multiple_of(50) {
                    15_000
                } else {
                    120
                };
            let bucket = |ms: u64| ms / 50;
            let sum = |window_ms: u64| -> u64 {
                let oldest = bucket(now).saturating_sub(window_ms / 50);
                log.iter()
                    .filter(|(t, _)| bucket(*t) >= oldest)
                    .map(|(_, e)| e)
                    .sum()
            };
            let limit = 1_000_000;
            let expected =
                (limit - sum(1000).min(limit)).min(2 * limit - sum(10_000).min(2 * limit));
            assert_eq!(
                windows.room(at(now), limit, 2 * limit),
                expected,
                "at {now} ms"
            );
            let energy = stream.next_u64() % 50_000;
            windows.book(at(now), energy);
            log.push((now, energy));
            log.retain(|(t, _)| *t + 12_000 > now);
        }
    }

    #[test]
    fn old_energy_leaves_and_time_going_back_does_no_harm() {
        let mut windows = Windows::new(1, 60);
        windows.book(at(100), 500);
        assert_eq!(windows.room(at(100), 600, 1000), 100);
        assert_eq!(windows.room(at(50), 600, 1000), 100);
        assert_eq!(windows.room(at(1_200), 600, 1000), 500);
        assert_eq!(windows.room(at(61_000), 600, 1000), 600);
        assert_eq!(windows.room(Instant::FAR_FUTURE, 600, 1000), 600);
    }
}
