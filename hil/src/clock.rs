//! The one place that reads a clock.

use std::time::Instant;

/// The wall clock, for measuring how long something took.
#[allow(clippy::disallowed_methods)]
pub fn now() -> Instant {
    Instant::now()
}
