//! What the summary of a real run says of its clock and its interfaces.

use palpate_buses::can::Tally;
use palpate_buses::pacer::Lateness;
use serde::Serialize;

/// How late the loop's turns began, microseconds after they were due.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct Pacing {
    /// Turns.
    pub turns: u64,
    /// Half of them at most this late, rounded up to a power of two.
    pub median_us: u64,
    /// 99 of 100 at most this late, rounded up to a power of two.
    pub p99_us: u64,
    /// The latest.
    pub worst_us: u64,
    /// Whether the loop had real-time priority.
    pub realtime: bool,
}

impl Pacing {
    pub(super) fn new(lateness: &Lateness, realtime: bool) -> Self {
        Self {
            turns: lateness.turns(),
            median_us: lateness.quantile_us(0.5),
            p99_us: lateness.quantile_us(0.99),
            worst_us: lateness.worst_us(),
            realtime,
        }
    }

    pub(in crate::run) fn words(&self) -> String {
        let priority = if self.realtime {
            "real-time priority"
        } else {
            "ordinary priority"
        };
        format!(
            "{} turns, late by {} us median, {} us p99, {} us at most; {priority}",
            self.turns, self.median_us, self.p99_us, self.worst_us
        )
    }
}

/// What came over an interface.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct CanReport {
    /// Its name when the run began.
    pub interface: String,
    /// Data frames received.
    pub frames: u64,
    /// Frames lost because this computer was too slow: in the kernel and in this program.
    pub lost: u64,
    /// Times the controller's own buffer ran over.
    pub overruns: u64,
    /// Error frames about the bus.
    pub errors: u64,
    /// Times the controller went bus-off.
    pub bus_off: u64,
    /// Frames whose time the controller itself told.
    pub hardware_stamps: u64,
}

impl CanReport {
    /// Of an interface and what has happened on it.
    pub fn new(interface: &str, tally: &Tally) -> Self {
        Self {
            interface: interface.into(),
            frames: tally.frames,
            lost: tally.dropped + tally.discarded,
            overruns: tally.overruns,
            errors: tally.bus_errors,
            bus_off: tally.bus_off,
            hardware_stamps: tally.hardware_stamps,
        }
    }

    /// In a line.
    pub fn words(&self) -> String {
        format!(
            "{} frames, {} lost, {} errors, bus-off {} times, times by the {}",
            self.frames,
            self.lost,
            self.errors + self.overruns,
            self.bus_off,
            if self.hardware_stamps > 0 {
                "controller"
            } else {
                "kernel"
            }
        )
    }
}
