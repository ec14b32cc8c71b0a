//! Time that this computer has been on: a clock that no one sets, for hardware that has to cool between two programs.

use std::fs;
use std::io;

use nix::time::ClockId;

use crate::pacer::nanoseconds;

/// Time since this computer was started, suspended or not, milliseconds.
pub fn uptime_ms() -> u64 {
    u64::try_from(nanoseconds(ClockId::CLOCK_BOOTTIME)).unwrap_or(0) / 1_000_000
}

/// Origin of [`uptime_ms`]: one start of this computer, as processes of one time namespace count it. `None` where the
/// system does not say.
pub fn uptime_start() -> Option<String> {
    let boot = fs::read_to_string("/proc/sys/kernel/random/boot_id").ok()?;
    let link = fs::read_link("/proc/self/ns/time").map(|link| link.display().to_string());
    let namespace = unless_absent(link)?;
    let offsets = unless_absent(fs::read_to_string("/proc/self/timens_offsets"))?;
    let all = [boot, namespace, offsets].join(" ");
    Some(all.split_whitespace().collect::<Vec<_>>().join(" "))
}

/// A kernel without time namespaces has no such file, and one count.
fn unless_absent(read: io::Result<String>) -> Option<String> {
    match read {
        Err(e) if e.kind() == io::ErrorKind::NotFound => Some(String::new()),
        read => read.ok(),
    }
}

#[cfg(test)]
#[path = "uptime_tests.rs"]
mod tests;
