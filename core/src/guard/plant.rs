//! What the guard must know of the hardware it protects, and what its pulses deliver at worst.

use core::fmt;

use crate::units::{Duration, Milliamps, Prescale, Ticks};

/// The slowest oscillator seen on a real chip, Hz: it makes the longest pulses and the longest periods.
const SLOWEST_HZ: u64 = 23_000_000;

/// How much longer the bus may take to switch wires off than to switch one on: eight channels against one at
/// 400 kbit/s, and as much again for the host.
pub(super) const SWITCHING: Duration = Duration::from_micros(1000);

/// What the guard must know of the hardware it protects.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Plant {
    /// PRE_SCALE of the boards.
    pub prescale: Prescale,
    /// Resistance of one wire with its leads, milliohms.
    pub wire_milliohm: u32,
    /// Current that the amplifiers are set to, and give whenever a pulse is high.
    pub peak: Milliamps,
}

impl Default for Plant {
    /// 75 um wires of 1.9 Ohm at 990 mA and 197 Hz: a current that contacts can sustain as long as they move.
    fn default() -> Self {
        Self {
            prescale: Prescale::new(30),
            wire_milliohm: 1900,
            peak: Milliamps(990),
        }
    }
}

/// Why a guard cannot protect this hardware.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PlantError {
    /// Resistance or current is zero or absurd (over 1 kOhm or 100 A).
    OutOfRange,
}

impl fmt::Display for PlantError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("expected a wire resistance of 1 to 1000000 milliohms and a peak current of 1 to 100000 mA")
    }
}

impl core::error::Error for PlantError {}

impl Plant {
    /// Whether these are figures that a wire can have.
    ///
    /// # Errors
    /// [`PlantError`] when not.
    pub(super) fn check(&self) -> Result<(), PlantError> {
        let plausible = |x: u32, most: u32| (1..=most).contains(&x);
        if plausible(self.wire_milliohm, 1_000_000) && plausible(self.peak.0, 100_000) {
            Ok(())
        } else {
            Err(PlantError::OutOfRange)
        }
    }

    /// Length of a tick at the slowest oscillator, picoseconds, rounded up.
    const fn tick_ps(&self) -> u64 {
        ((self.prescale.get() as u64 + 1) * 1_000_000_000_000).div_ceil(SLOWEST_HZ)
    }

    /// The widest pulse that is not longer than `ns` at the slowest oscillator; never a full period.
    pub(super) fn widest(&self, ns: u64) -> u16 {
        (ns.saturating_mul(1000) / self.tick_ps()).min(u64::from(Ticks::PER_PERIOD) - 1) as u16
    }

    /// Length of a period at the slowest oscillator, rounded up.
    pub(super) const fn period(&self) -> Duration {
        Duration::from_micros((self.tick_ps() * Ticks::PER_PERIOD as u64).div_ceil(1_000_000))
    }

    /// Longest time from a command to the last edge it moves: the write, the end of the period in which it
    /// arrives, and the pulse's place in the next.
    pub(super) fn latency(&self) -> Duration {
        self.period() + self.period() + SWITCHING
    }

    /// How much longer than asked a channel may be on, as its energy counts: one period and the bus.
    pub(super) fn surplus(&self) -> Duration {
        self.period() + SWITCHING
    }

    /// Electrical energy, nJ, of pulses of `width` ticks for a `span`: from above over all oscillators.
    ///
    /// Each period of length T that starts within the span, lengthened by the bus to S, brings
    /// `I^2 R T width / 4096`, and `floor(S / T) + 1` can. At the slowest T that are n = ceil(S / T). A faster
    /// oscillator fits one more in only if T <= S / n: together they last at most (n + 1) S / n.
    pub(super) fn energy_nj(&self, width: u16, span: Duration) -> u64 {
        let span = (span + SWITCHING).as_micros();
        let slowest = self.period().as_micros();
        let n = span.div_ceil(slowest);
        let on_us = n
            .saturating_mul(slowest)
            .max(span.saturating_add(span.div_ceil(n)));
        const PER_NJ: u64 = 4096 * 1_000_000;
        let current = u64::from(self.peak.0);
        // At most 1e16 for a plausible plant; the rest overflows only beyond minutes.
        let nanowatt = current * current * u64::from(self.wire_milliohm);
        let short = nanowatt
            .checked_mul(on_us)
            .and_then(|x| x.checked_mul(u64::from(width)));
        if let Some(short) = short {
            return short.div_ceil(PER_NJ);
        }
        let long = u128::from(nanowatt) * u128::from(on_us) * u128::from(width);
        let nj = long.div_ceil(u128::from(PER_NJ));
        nj.min(u128::from(u64::MAX / 4)) as u64
    }
}

#[cfg(test)]
#[path = "plant_tests.rs"]
mod tests;
