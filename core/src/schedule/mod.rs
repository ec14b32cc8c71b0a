//! Stimuli, how width and current share their level, staggering, and the entry of a schedule that `hil review` shows a person: integers only.

mod share;
mod stagger;

pub use share::Share;
pub use stagger::stagger;

use crate::listed::listed;
use crate::units::{Board, Channel, Duration, Instant, Milliamps, Ticks};

/// Most stimuli in a command to a driver unit: eight wires on each of sixteen boards.
pub const MOST_PLANNED: usize = 128;

/// Request of the illusion to one wire: a pulse train of a width and a peak current for a while.
///
/// Duty and current stand apart: an amplifier may have a current of its own, or one that is set.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Stimulus {
    /// Index of the wire in the display's layout.
    pub wire: u16,
    /// Pulse width asked for, in ticks of the board's PWM period.
    pub width: Ticks,
    /// Current while the pulse is high, where the amplifier's is set; one with a current of its own gives that.
    pub peak: Milliamps,
    /// Onset.
    pub at: Instant,
    /// End of the burst: onset + tau_d.
    pub until: Instant,
}

listed! {
    /// Reasons for which the applied stimulus differs from the requested one.
    #[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
    #[non_exhaustive]
    pub enum Reason: word {
        /// The pulse would have been longer than the limit.
        PulseWidth = "pulse-width",
        /// The burst would have lasted longer, or delivered more energy, than the limit.
        Burst = "burst",
        /// The supply could not feed all wires on at this instant.
        SupplyCurrent = "supply-current",
        /// The wire's mean power over a window would have passed the limit.
        WirePower = "wire-power",
        /// The fingertip's mean power over a window would have passed the limit.
        FingertipPower = "fingertip-power",
        /// The skin 0.1 mm deep would have passed its limit at some time.
        SkinPeak = "skin-peak",
        /// The skin 0.1 mm deep would have passed its limit as a mean over 10 s.
        SkinMean = "skin-mean",
        /// The skin 0.4 mm deep would have passed its limit at some time.
        SkinDeep = "skin-deep",
        /// Too little is left of the session's dose for so warm a burst.
        Dose = "dose",
        /// The guard is latched: everything stays off until the cause is cleared.
        Latched = "latched",
        /// The current would have been more than the amplifier can be set to, or would have risen while the wire was on.
        Current = "current",
        /// The contactor of a motor would have moved further than its limit.
        Displacement = "displacement",
        /// The coil of a motor would have become warmer than its limit.
        CoilHeat = "coil-heat",
        /// The motor would have been on for a larger part of ten seconds than its limit.
        Duty = "duty",
        /// The guard's actuators are of another kind than the update's.
        Plant = "plant",
    }
}

/// One line of the schedule: what a channel was told, what had been asked, and why they differ.
///
/// Sorted by time, board and channel. A channel that goes (or is held) off has `on == off`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Entry {
    /// The onset on the grid; the write follows in the same turn.
    pub at: Instant,
    /// The board.
    pub board: Board,
    /// The channel.
    pub channel: Channel,
    /// Tick at which the pulse starts in each period.
    pub on: u16,
    /// Tick at which the pulse ends in each period.
    pub off: u16,
    /// Time at which the channel goes off: onset + tau_d, or earlier where the burst row cuts it.
    pub until: Instant,
    /// Width asked for, in ticks.
    pub requested: Ticks,
    /// End asked for: [`Self::until`], or later where the burst row cut it.
    pub requested_until: Instant,
    /// Current that the amplifier was to be set to; `None` where it has a current of its own.
    pub current: Option<Milliamps>,
    /// Reason for which the applied width (`off - on`) or end is not the requested one; where the guard only observed,
    /// for which it would not be.
    pub reason: Option<Reason>,
}

impl Entry {
    /// The width applied, in ticks.
    pub const fn width(&self) -> Ticks {
        Ticks::new(self.off.saturating_sub(self.on))
    }

    /// Pulses applied, of this period: those of its length, or none where the width is none.
    pub const fn pulses(&self, period_ns: u64) -> u64 {
        if self.off > self.on {
            periods(self.at, self.until, period_ns)
        } else {
            0
        }
    }

    /// Pulses asked for, of this period, whatever their width.
    pub const fn requested_pulses(&self, period_ns: u64) -> u64 {
        periods(self.at, self.requested_until, period_ns)
    }
}

/// Periods that begin between two times; none without a period. The chip's counter begins with the onset (it stands still
/// while all outputs of a board are off: data sheet 7.3.3, remark), and a channel goes off with the period that its end lies
/// in.
const fn periods(at: Instant, until: Instant, period_ns: u64) -> u64 {
    if period_ns == 0 {
        return 0;
    }
    let length_ns = until.since(at).as_micros().saturating_mul(1000);
    length_ns.div_ceil(period_ns)
}

/// Duration of a stimulus and time between onsets.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Timing {
    /// Stimulus duration tau_d.
    pub duration: Duration,
    /// Stimulus onset asynchrony tau_SOA.
    pub soa: Duration,
}
