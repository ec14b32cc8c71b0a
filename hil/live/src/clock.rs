//! The clock that measures cost and dates recordings. A run on hardware is paced by `palpate_buses::pacer`.

use std::sync::OnceLock;
use std::time::{Duration, Instant, SystemTime};

/// Wall clock, for measuring durations.
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

/// A time since 1970 as a date of the Gregorian calendar and a time of day, both of UTC: `2026-11-22 20:33 UTC`.
/// Days to dates as H. Hinnant, "chrono-compatible low-level date algorithms" (2013).
pub fn date(unix_us: u64) -> String {
    let minutes = unix_us / 60_000_000;
    let days = minutes / 1440 + 719_468; // since 0000-03-01
    let (era, day) = (days / 146_097, days % 146_097);
    let year = (day - day / 1460 + day / 36_524 - day / 146_096) / 365;
    let of_year = day - (365 * year + year / 4 - year / 100);
    let month = (5 * of_year + 2) / 153;
    let of_month = of_year - (153 * month + 2) / 5 + 1;
    let (month, next) = if month < 10 {
        (month + 3, 0)
    } else {
        (month - 9, 1)
    };
    format!(
        "{}-{month:02}-{of_month:02} {:02}:{:02} UTC",
        era * 400 + year + next,
        minutes / 60 % 24,
        minutes % 60
    )
}

#[cfg(test)]
#[path = "clock_tests.rs"]
mod tests;
