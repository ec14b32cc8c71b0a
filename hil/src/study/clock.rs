//! The time of a session, in which what was played cools. Only the uptime of the computer moves it on: a clock that is set
//! forward cools no one's finger.

use palpate_buses::uptime::{uptime_ms, uptime_start};
use palpate_study::Uptime;

/// Reads how long this computer has been on.
#[must_use]
pub fn uptime() -> Uptime {
    Uptime {
        start: uptime_start(),
        ms: uptime_ms(),
    }
}

/// A session's clock, which goes on from where a record left it.
#[derive(Debug, Clone, Copy)]
pub struct SessionClock {
    at_ms: u64,
    uptime_ms: u64,
}

impl SessionClock {
    /// A clock that stands at `at_ms` of the session at a reading of uptime.
    #[must_use]
    pub const fn new(at_ms: u64, at: &Uptime) -> Self {
        Self {
            at_ms,
            uptime_ms: at.ms,
        }
    }

    /// Milliseconds since the session began.
    #[must_use]
    pub fn now_ms(self) -> u64 {
        let passed = uptime_ms().saturating_sub(self.uptime_ms);
        self.at_ms.saturating_add(passed)
    }
}
