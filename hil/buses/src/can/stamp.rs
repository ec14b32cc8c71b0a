//! Translates the kernel's and the controller's time stamps to the run's clock.
//!
//! The kernel stamps with CLOCK_REALTIME, which may be set at any moment; a controller counts from
//! wherever it likes and drifts. Neither may make a frame come from the future or before the last one.

use palpate_core::units::Instant;

use super::socket::Packet;
use crate::pacer::{RunClock, monotonic_ns, realtime_ns};

/// Age of a stamp beyond which it does not count: the clock was set, or the frame belongs to another run.
const OLDEST_NS: i64 = 1_000_000_000;
/// Jump of a controller's clock beyond which it counts as set anew.
const JUMP_NS: i64 = 20_000_000;
/// The most by which a controller's clock drifts against ours: one part in this many.
const DRIFT: i64 = 5_000;

/// The times of one interface's frames.
#[derive(Debug)]
pub struct Stamps {
    clock: RunClock,
    /// Our clock less the controller's, and the controller's time at which that was found.
    offset: Option<(i64, i64)>,
    last: Instant,
    hardware: u64,
}

impl Stamps {
    /// Stamps on this clock.
    pub fn new(clock: RunClock) -> Self {
        Self {
            clock,
            offset: None,
            last: Instant::ZERO,
            hardware: 0,
        }
    }

    /// Time at which a packet was received: by the controller where it says so, else by the kernel, else now.
    pub fn time(&mut self, packet: &Packet) -> Instant {
        self.at(packet, monotonic_ns(), realtime_ns())
    }

    /// Frames that carried a controller's stamp.
    pub const fn hardware(&self) -> u64 {
        self.hardware
    }

    fn at(&mut self, packet: &Packet, monotonic: i64, realtime: i64) -> Instant {
        let age = packet
            .software_ns
            .map(|stamp| realtime.saturating_sub(stamp));
        let age = age.filter(|age| (0..=OLDEST_NS).contains(age)).unwrap_or(0);
        let arrived = monotonic - age;
        let at = match packet.hardware_ns {
            Some(hardware) => {
                self.hardware += 1;
                self.by_controller(hardware, arrived)
            }
            None => arrived,
        };
        // One interface's frames are in order whatever the clocks do.
        self.last = self.last.max(self.clock.instant(at.min(monotonic)));
        self.last
    }

    /// A controller's time on our clock. A frame can only be seen late, so the smallest distance between
    /// the clocks is the true one; it may grow no faster than clocks drift.
    fn by_controller(&mut self, hardware: i64, arrived: i64) -> i64 {
        let seen = arrived.saturating_sub(hardware);
        let offset = match self.offset {
            Some((offset, since)) if (seen - offset).abs() < JUMP_NS => {
                let grown = hardware.saturating_sub(since).max(0) / DRIFT;
                seen.min(offset.saturating_add(grown))
            }
            _ => seen,
        };
        self.offset = Some((offset, hardware));
        hardware.saturating_add(offset)
    }
}

#[cfg(test)]
#[path = "stamp_tests.rs"]
mod tests;
