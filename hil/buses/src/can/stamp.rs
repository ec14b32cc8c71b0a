//! From the kernel's and the controller's time stamps to the run's clock.
//!
//! The kernel stamps with CLOCK_REALTIME, which may be set at any moment; a controller counts from
//! wherever it likes and drifts. Neither may make a frame come from the future or before the last one.

use palpate_core::units::Instant;

use super::socket::Packet;
use crate::pacer::{RunClock, monotonic_ns, realtime_ns};

/// A stamp older than this is none: the clock was set, or the frame belongs to another run.
const OLDEST_NS: i64 = 1_000_000_000;
/// A controller's clock that is off by more than this has been set anew.
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
    /// Times on this clock.
    pub fn new(clock: RunClock) -> Self {
        Self {
            clock,
            offset: None,
            last: Instant::ZERO,
            hardware: 0,
        }
    }

    /// When a packet was received: the controller's word where there is one, else the kernel's, else now.
    pub fn of(&mut self, packet: &Packet) -> Instant {
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
mod tests {
    use super::*;
    use crate::can::socket::Content;

    const MS: i64 = 1_000_000;

    fn packet(software_ns: Option<i64>, hardware_ns: Option<i64>) -> Packet {
        Packet {
            content: Content::Other,
            software_ns,
            hardware_ns,
            dropped: None,
        }
    }

    /// Stamps on a clock that starts at 10 s of the monotonic one.
    fn stamps() -> (Stamps, i64) {
        let clock = RunClock::start();
        let start = monotonic_ns();
        (Stamps::new(clock), start)
    }

    #[test]
    fn the_kernels_stamp_says_how_old_a_frame_is() {
        let (mut stamps, start) = stamps();
        let now = start + 50 * MS;
        let at = stamps.at(&packet(Some(900 * MS), None), now, 907 * MS);
        assert_eq!(at, stamps.clock.instant(now - 7 * MS));
    }

    #[test]
    fn a_clock_that_was_set_counts_for_nothing() {
        for realtime in [0, 5_000 * MS, i64::MAX] {
            let (mut stamps, start) = stamps();
            let at = stamps.at(&packet(Some(900 * MS), None), start + 50 * MS, realtime);
            assert_eq!(at, stamps.clock.instant(start + 50 * MS), "{realtime}");
        }
    }

    #[test]
    fn frames_of_one_interface_stay_in_order() {
        let (mut stamps, start) = stamps();
        let first = stamps.at(&packet(None, None), start + 50 * MS, 0);
        let second = stamps.at(&packet(Some(900 * MS), None), start + 51 * MS, 910 * MS);
        assert!(second >= first);
    }

    #[test]
    fn a_controllers_stamps_take_the_systems_delay_out() {
        let (mut stamps, start) = stamps();
        // Every 10 ms by the controller; seen 1 to 4 ms late.
        let seen = |n: i64| start + n * 10 * MS + (1 + n % 4) * MS;
        let mut times = Vec::new();
        for n in 1..=20 {
            times.push(stamps.at(&packet(None, Some(7 * MS + n * 10 * MS)), seen(n), 0));
        }
        for pair in times[4..].windows(2) {
            let apart = pair[1].since(pair[0]).as_micros();
            assert!((9_990..=10_010).contains(&apart), "{apart}");
        }
        assert_eq!(stamps.hardware(), 20);
        // Set anew: a new distance at once.
        let at = stamps.at(&packet(None, Some(1)), seen(21), 0);
        assert_eq!(at, stamps.clock.instant(seen(21)));
    }
}
