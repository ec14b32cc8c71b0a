//! The unit's clock as the host sees it: an offset with an error that is known.
//!
//! An answer says when the unit took a command and when it answered. Host times around both enclose the offset, as in
//! NTP (RFC 5905, 8). The narrowest enclosure of the last half second counts, so that a delayed datagram does no harm
//! and a clock that drifts by 1 % is off by 5 ms at most.

use crate::units::{Duration, Instant};

/// The narrowest enclosure is looked for anew this often.
const WINDOW: Duration = Duration::from_millis(250);

/// Unit time less host time, microseconds: between two numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Enclosure {
    least: i64,
    most: i64,
}

impl Enclosure {
    const fn width(self) -> i64 {
        self.most.saturating_sub(self.least)
    }
}

/// Relation of the unit's clock to the host's.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Sync {
    /// Narrowest enclosure of this window, and of the one before.
    best: [Option<Enclosure>; 2],
    since: Instant,
}

/// Times of one exchange: two of the host, two of the unit.
#[derive(Clone, Copy, Debug)]
pub(super) struct Exchange {
    pub(super) sent: Instant,
    pub(super) taken: Instant,
    pub(super) answered: Instant,
    pub(super) heard: Instant,
}

const fn micros(at: Instant) -> i64 {
    at.as_micros() as i64 // a run is shorter than 292 000 years
}

const fn instant(micros: i64) -> Instant {
    Instant::from_micros(if micros < 0 { 0 } else { micros as u64 })
}

impl Sync {
    /// Takes an exchange in.
    pub(super) fn add(&mut self, e: Exchange) {
        let one = Enclosure {
            least: micros(e.answered) - micros(e.heard),
            most: micros(e.taken) - micros(e.sent),
        };
        // A unit whose answer comes before its question was asked has begun anew.
        if one.width() < 0 {
            return;
        }
        if e.heard.since(self.since) >= WINDOW {
            self.best = [None, self.best[0]];
            self.since = e.heard;
        }
        let narrower = |best: &Enclosure| one.width() < best.width();
        if self.best[0].as_ref().is_none_or(narrower) {
            self.best[0] = Some(one);
        }
    }

    fn now(&self) -> Option<Enclosure> {
        let both = self.best.iter().flatten();
        both.copied().min_by_key(|e| e.width())
    }

    /// A time of the host in the unit's.
    pub(super) fn unit_time(&self, host: Instant) -> Option<Instant> {
        let e = self.now()?;
        Some(instant(micros(host) + e.least + e.width() / 2))
    }

    /// A time of the host in the unit's, at its least: never later than the true one.
    pub(super) fn earliest(&self, host: Instant) -> Option<Instant> {
        Some(instant(micros(host) + self.now()?.least))
    }
}

#[cfg(test)]
#[path = "sync_tests.rs"]
mod tests;
