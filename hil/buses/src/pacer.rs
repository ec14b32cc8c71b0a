//! The clock of a real run and the pacer of its loop: absolute times, so that lateness never adds up, and a tally of
//! the lateness of each turn.

use nix::errno::Errno;
use nix::sys::time::TimeSpec;
use nix::time::{ClockId, ClockNanosleepFlags, clock_gettime, clock_nanosleep};
use palpate_core::units::{Duration, Instant};

/// CLOCK_MONOTONIC, counted from the start of a run. Copies count from the same moment.
#[derive(Clone, Copy, Debug)]
pub struct RunClock {
    epoch_ns: i64,
}

impl RunClock {
    /// A clock that reads zero now.
    pub fn start() -> Self {
        Self {
            epoch_ns: monotonic_ns(),
        }
    }

    /// Start of the clock, CLOCK_MONOTONIC in nanoseconds: the same for all programs of a machine.
    pub const fn epoch_ns(&self) -> i64 {
        self.epoch_ns
    }

    /// The time since the start, in whole microseconds.
    pub fn now(&self) -> Instant {
        self.instant(monotonic_ns())
    }

    /// Time of a reading of CLOCK_MONOTONIC (ns) on this clock; zero for one before the start.
    pub fn instant(&self, monotonic_ns: i64) -> Instant {
        let ns = monotonic_ns.saturating_sub(self.epoch_ns);
        Instant::from_micros(u64::try_from(ns).unwrap_or(0) / 1000)
    }

    /// Sleeps until `until` and returns at once when that is past. A signal does not cut it short.
    pub fn sleep_until(&self, until: Instant) {
        let ns = i64::try_from(until.as_micros().saturating_mul(1000)).unwrap_or(i64::MAX);
        let at = self.epoch_ns.saturating_add(ns);
        let at = TimeSpec::new(at / 1_000_000_000, at % 1_000_000_000);
        let absolute = ClockNanosleepFlags::TIMER_ABSTIME;
        while clock_nanosleep(ClockId::CLOCK_MONOTONIC, absolute, &at) == Err(Errno::EINTR) {}
    }
}

/// CLOCK_MONOTONIC in nanoseconds.
pub(crate) fn monotonic_ns() -> i64 {
    nanoseconds(ClockId::CLOCK_MONOTONIC)
}

/// Time that the machine has slept since it was started, nanoseconds: CLOCK_BOOTTIME less CLOCK_MONOTONIC.
pub fn asleep_ns() -> i64 {
    // Monotonic first: time between the two readings makes no sleep of less than nothing.
    let monotonic = monotonic_ns();
    nanoseconds(ClockId::CLOCK_BOOTTIME).saturating_sub(monotonic)
}

/// CLOCK_REALTIME in nanoseconds since 1970, the clock of the kernel's stamps.
pub(crate) fn realtime_ns() -> i64 {
    nanoseconds(ClockId::CLOCK_REALTIME)
}

/// A reading of a clock, nanoseconds.
pub(crate) fn nanoseconds(clock: ClockId) -> i64 {
    // Both clocks exist on every Linux; zero would be a clock that stands still, which the loop reports.
    clock_gettime(clock).map_or(0, |t| t.tv_sec() * 1_000_000_000 + t.tv_nsec())
}

/// Delay of a look beyond which the time since the last one counts as unseen.
pub const UNSEEN: Duration = Duration::from_millis(100);
/// Sleep of the machine above which it counts as a suspend.
pub const ASLEEP: Duration = Duration::from_millis(20);

/// Time in which a loop did not get to act.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum Unseen {
    /// The clock went on meanwhile: a debugger, a frozen container, too much load.
    #[error("unseen time: this computer let this program stand still for {} ms, and outputs may have been on meanwhile", .0.as_micros() / 1000)]
    Stood(Duration),
    /// The machine slept, and its clock stood still.
    #[error("unseen time: this computer was suspended for {} ms, and outputs may have been on meanwhile", .0.as_micros() / 1000)]
    Slept(Duration),
}

impl Unseen {
    /// Part of the time that the run's clock did not count.
    pub const fn uncounted(self) -> Duration {
        match self {
            Self::Stood(_) => Duration::ZERO,
            Self::Slept(span) => span,
        }
    }
}

/// Notices time in which a loop did not get to act, from its first look on.
#[derive(Clone, Copy, Debug, Default)]
pub struct Watch {
    last: Option<(Instant, i64)>,
}

impl Watch {
    /// A watch before its first look.
    pub const fn new() -> Self {
        Self { last: None }
    }

    /// Looks at `now` of the run's clock, before anything else of a turn.
    pub fn look(&mut self, now: Instant) -> Option<Unseen> {
        self.look_at(now, asleep_ns())
    }

    fn look_at(&mut self, now: Instant, asleep_ns: i64) -> Option<Unseen> {
        let (before, asleep_before) = self.last.replace((now, asleep_ns))?;
        let slept = u64::try_from(asleep_ns.saturating_sub(asleep_before)).unwrap_or(0);
        let (slept, passed) = (Duration::from_micros(slept / 1000), now.since(before));
        match (slept > ASLEEP, passed > UNSEEN) {
            (true, _) => Some(Unseen::Slept(slept)),
            (_, true) => Some(Unseen::Stood(passed)),
            _ => None,
        }
    }
}

/// Lateness of a loop's turns: a histogram whose bins are powers of two of a microsecond.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Lateness {
    /// Turns that began less than 2^n microseconds late, and not less than half of that.
    bins: [u64; 32],
    worst_us: u64,
}

impl Lateness {
    /// Counts a turn that was due at `due` and began at `began`.
    pub fn note(&mut self, due: Instant, began: Instant) {
        let late = began.since(due).as_micros();
        let bin = (u64::BITS - late.leading_zeros()) as usize;
        self.bins[bin.min(self.bins.len() - 1)] += 1;
        self.worst_us = self.worst_us.max(late);
    }

    /// Adds the turns of another loop.
    pub fn add(&mut self, other: &Self) {
        let bins = self.bins.iter_mut().zip(other.bins);
        bins.for_each(|(own, others)| *own += others);
        self.worst_us = self.worst_us.max(other.worst_us);
    }

    /// Turns counted.
    pub fn turns(&self) -> u64 {
        self.bins.iter().sum()
    }

    /// Lateness of the latest turn, microseconds.
    pub const fn worst_us(&self) -> u64 {
        self.worst_us
    }

    /// Lateness that a share (0 to 1) of the turns does not exceed, microseconds: the upper end of the bin that holds
    /// it, never above the worst.
    pub fn quantile_us(&self, share: f64) -> u64 {
        let rank = (share * self.turns() as f64).ceil() as u64;
        let mut below = 0;
        for (bin, count) in self.bins.iter().enumerate() {
            below += count;
            if below >= rank {
                return ((1u64 << bin) - 1).min(self.worst_us);
            }
        }
        self.worst_us
    }
}

/// Calls a loop's turns at absolute times.
#[derive(Debug)]
pub struct Pacer {
    clock: RunClock,
    lateness: Lateness,
}

impl Pacer {
    /// A pacer on this clock.
    pub fn new(clock: RunClock) -> Self {
        Self {
            clock,
            lateness: Lateness::default(),
        }
    }

    /// Waits until `due`, and returns the true time.
    pub fn wait(&mut self, due: Instant) -> Instant {
        self.clock.sleep_until(due);
        let now = self.clock.now();
        self.lateness.note(due, now);
        now
    }

    /// The first turn after `now` on a grid of `step` from zero: a turn that took too long is made up by
    /// leaving turns out, not by hurrying.
    pub fn next(now: Instant, step: Duration) -> Instant {
        let step = step.as_micros().max(1);
        Instant::from_micros(
            (now.as_micros() / step)
                .saturating_add(1)
                .saturating_mul(step),
        )
    }

    /// Lateness of the turns so far.
    pub const fn lateness(&self) -> &Lateness {
        &self.lateness
    }
}

#[cfg(test)]
#[path = "pacer_tests.rs"]
mod tests;
