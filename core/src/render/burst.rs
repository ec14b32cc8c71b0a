//! Bursts that another has shaped: a known stroke's length, or the periods that a texture leaves.

use crate::guard::Guard;
use crate::units::{Duration, Instant, Ticks};

/// Periods of a burst, at most.
const MOST: u32 = u128::BITS;

/// How a burst is shaped where the pattern does not say.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Burst {
    /// Every wire is on for as long.
    Long(Duration),
    /// Only these periods pulse.
    Woven(Periods),
}

/// The periods of a burst that pulse, after one another or apart. The counter of a board begins anew with each run of them,
/// since all its outputs are off between two. So a run ends in the middle of its last period: up to four pulses are then
/// exact at any oscillator, as in a [`Pattern`](super::Pattern).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Periods {
    /// A bit for each.
    pulses: u128,
    period_ns: u64,
    /// No run ends later.
    longest: Duration,
}

/// Pulses without a pause between them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Run {
    /// When the first period begins.
    pub at: Instant,
    /// When the wires go off.
    pub until: Instant,
    /// The period after the last one that pulses.
    pub next: u32,
}

impl Periods {
    /// A bit for each period that pulses, of this length and within `longest`.
    pub const fn new(pulses: u128, period_ns: u64, longest: Duration) -> Self {
        Self {
            pulses,
            period_ns,
            longest,
        }
    }

    /// How many pulse.
    pub const fn count(&self) -> u8 {
        self.pulses.count_ones() as u8 // at most 128
    }

    /// By how much pulses get wider because so many are left out: what is felt grows with the width and with the root of the
    /// number of pulses.
    pub fn gain(&self) -> f32 {
        let all = (self.longest.as_micros() * 1000).div_ceil(self.period_ns.max(1));
        libm::sqrtf(all as f32 / f32::from(self.count().max(1)))
    }

    /// The first run, of a burst that begins at `onset`, whose first period is `n` or later.
    pub fn run(&self, onset: Instant, n: u32) -> Option<Run> {
        let find = |bits: u128, from: u32| {
            let rest = bits.checked_shr(from);
            rest.map_or(MOST, |rest| from + rest.trailing_zeros())
        };
        let first = find(self.pulses, n);
        if first >= MOST {
            return None;
        }
        let next = find(!self.pulses, first).min(MOST);
        Some(Run {
            at: onset + self.halves(2 * first),
            until: onset + self.halves(2 * next - 1),
            next,
        })
    }

    /// Every run of a burst that begins at zero.
    fn runs(&self) -> impl Iterator<Item = Run> {
        let first = self.run(Instant::ZERO, 0);
        core::iter::successors(first, |run| self.run(Instant::ZERO, run.next))
    }

    /// When a wire goes off that has the first so many pulses.
    pub(super) fn lasts(&self, pulses: u8) -> Duration {
        let mut left = self.pulses;
        for _ in 1..pulses {
            left &= left.saturating_sub(1); // the lowest bit goes
        }
        match left {
            0 => self.longest,
            _ => self.halves(2 * left.trailing_zeros() + 1),
        }
    }

    /// So many half periods after the onset.
    fn halves(&self, halves: u32) -> Duration {
        Duration::from_micros(u64::from(halves) * self.period_ns / 2000).min(self.longest)
    }
}

impl Burst {
    /// Pulses that fit in, of this period.
    pub(super) fn pulses(&self, period_ns: u64) -> u8 {
        match self {
            Self::Long(length) => (length.as_micros() * 1000)
                .div_ceil(period_ns)
                .clamp(1, u64::from(u8::MAX)) as u8,
            Self::Woven(periods) => periods.count().max(1),
        }
    }

    /// Pulses of this width where none is left out, as wide as they are here.
    pub(super) fn widened(&self, width: Ticks, widest: Ticks) -> Ticks {
        match self {
            Self::Long(_) => width,
            // Rounded down: the widest stays within the limit.
            Self::Woven(periods) => {
                let wide = (f32::from(width.get()) * periods.gain()) as u16;
                Ticks::new(wide).min(widest)
            }
        }
    }

    /// How long a wire with so many of its pulses is on.
    pub(super) fn lasts(&self, pulses: u8) -> Duration {
        match self {
            Self::Long(length) => *length,
            Self::Woven(periods) => periods.lasts(pulses),
        }
    }

    /// Electrical energy, nJ, that the guard books in all for a wire that is on for this long at most.
    pub(super) fn energy_nj(&self, guard: &Guard, width: Ticks, length: Duration) -> u64 {
        match self {
            Self::Long(_) => guard.energy_nj(width, length),
            Self::Woven(periods) => {
                let end = Instant::ZERO + length;
                let on = periods.runs().take_while(|run| run.at < end);
                on.map(|run| guard.energy_nj(width, run.until.min(end).since(run.at)))
                    .sum()
            }
        }
    }
}

#[cfg(test)]
#[path = "burst_tests.rs"]
mod tests;
