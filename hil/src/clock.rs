//! The clock that measures cost and dates recordings. A run on hardware is paced by `palpate_buses::pacer`.

use std::sync::OnceLock;
use std::time::{Duration, Instant, SystemTime};

/// The wall clock, for measuring how long something took.
#[allow(clippy::disallowed_methods)]
pub fn now() -> Instant {
    Instant::now()
}

/// The time since the first call: a stopwatch for rooms without a clock.
pub fn elapsed() -> Duration {
    static START: OnceLock<Instant> = OnceLock::new();
    START.get_or_init(now).elapsed()
}

/// Microseconds since 1970, for recordings that begin at a time of day; zero on a machine that thinks it is
/// earlier.
#[allow(clippy::disallowed_methods)]
pub fn unix_us() -> u64 {
    let since = SystemTime::now().duration_since(SystemTime::UNIX_EPOCH);
    since.map_or(0, |d| u64::try_from(d.as_micros()).unwrap_or(u64::MAX))
}
