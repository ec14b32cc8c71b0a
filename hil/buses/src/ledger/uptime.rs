//! Time that only the machine's uptime moves forward. No date takes part that a person, a network or a battery sets.

use std::sync::OnceLock;

use nix::time::ClockId;
use palpate_core::units::Duration;

use super::account::checksum;
use crate::pacer::nanoseconds;
use crate::uptime::uptime_start;

/// A moment: the start of the machine, and the time after it, by CLOCK_BOOTTIME.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Uptime {
    /// Number of the machine's start; zero where that is not known.
    pub(super) boot: u64,
    /// Time since the start, microseconds.
    pub(super) us: u64,
}

impl Uptime {
    pub(super) fn now() -> Self {
        static BOOT: OnceLock<u64> = OnceLock::new();
        let ns = u64::try_from(nanoseconds(ClockId::CLOCK_BOOTTIME)).unwrap_or(0);
        Self {
            boot: *BOOT.get_or_init(boot),
            us: ns / 1000,
        }
    }

    /// Time since another moment; `None` where that is not known: of another start of the machine, or by a clock that
    /// went back.
    pub(super) fn since(self, earlier: Self) -> Option<Duration> {
        let is_known = self.boot != 0 && self.boot == earlier.boot;
        let us = self.us.checked_sub(earlier.us).filter(|_| is_known);
        us.map(Duration::from_micros)
    }

    pub(super) const fn after(self, span: Duration) -> Self {
        Self {
            us: self.us.saturating_add(span.as_micros()),
            ..self
        }
    }
}

/// A number for the start of the machine, as processes of one time namespace count it.
fn boot() -> u64 {
    uptime_start().map_or(0, |start| checksum(start.as_bytes()).max(1))
}

#[cfg(test)]
#[path = "uptime_tests.rs"]
mod tests;
