//! The hardware that the guard protects, as far as it must know it, and the energy that its pulses deliver at worst.

use super::kernel::WornWire;
use crate::units::{Duration, Milliamps, Prescale, Ticks};

/// The slowest internal oscillator seen on a real chip, Hz: it makes the longest pulses and the longest periods.
const SLOWEST_HZ: u64 = 23_000_000;
/// Parts per million of a whole.
const MILLION: u64 = 1_000_000;

/// The most by which the bus delays switching wires off against switching one on: eight channels against one at 400
/// kbit/s, and as much again for the host.
const SWITCHING: Duration = Duration::from_micros(1000);

/// The hardware that a guard protects, as far as it must know it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Plant {
    /// PRE_SCALE of the boards.
    pub prescale: Prescale,
    /// Resistance of one wire with its leads, milliohms.
    pub wire_milliohm: u32,
    /// Current that the amplifiers give whenever a pulse is high; the most that they can where their current is set.
    pub peak: Milliamps,
    /// The longest that transfers of other displays may hold up one of these boards on a shared bus; else zero.
    pub bus: Duration,
}

impl Default for Plant {
    /// The plant of 75 um wires of 1.9 Ohm at 990 mA and 197 Hz: contacts can sustain that current while they move.
    fn default() -> Self {
        Self {
            prescale: Prescale::new(30),
            wire_milliohm: 1900,
            peak: Milliamps(990),
            bus: Duration::ZERO,
        }
    }
}

/// Reasons for which a guard cannot protect this hardware.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum PlantError {
    /// A resistance or current that is zero or absurd (over 1 kOhm or 100 A).
    #[error(
        "expected a wire resistance of 1 to 1000000 milliohms and a peak current of 1 to 100000 mA"
    )]
    OutOfRange,
    /// A limit of motors that is no number above zero, or a duty above 1.
    #[error("expected limits of motors that are finite and above zero, and a duty of at most 1")]
    Motor,
    /// A wire that is thinner or thicker than the rows of heat know.
    #[error(
        "expected a wire of {} to {} um in diameter: the guard has rows of heat for no other",
        WornWire::DIAMETER_NM.start() / 1000,
        WornWire::DIAMETER_NM.end() / 1000
    )]
    Diameter,
    /// A wire that is shorter or longer than the rows of heat know.
    #[error(
        "expected a wire of {} to {} mm in length: the guard has rows of heat for no other",
        WornWire::LENGTH_UM.start() / 1000,
        WornWire::LENGTH_UM.end() / 1000
    )]
    Length,
    /// A finger that is colder or warmer than the rows of heat know.
    #[error(
        "expected a finger of {} to {} C at rest: the guard has rows of heat for no other",
        WornWire::REST_MC.start() / 1000,
        WornWire::REST_MC.end() / 1000
    )]
    Rest,
}

impl Plant {
    /// Checks that a wire can have these figures.
    ///
    /// # Errors
    /// [`PlantError`] if none can.
    pub(super) fn check(&self) -> Result<(), PlantError> {
        let plausible = |x: u32, most: u32| (1..=most).contains(&x);
        if plausible(self.wire_milliohm, 1_000_000) && plausible(self.peak.0, 100_000) {
            Ok(())
        } else {
            Err(PlantError::OutOfRange)
        }
    }

    /// The worse of both, board by board alike: the larger current, resistance and wait. The divider stays.
    #[must_use]
    pub fn worse(self, other: &Self) -> Self {
        Self {
            prescale: self.prescale,
            wire_milliohm: self.wire_milliohm.max(other.wire_milliohm),
            peak: self.peak.max(other.peak),
            bus: self.bus.max(other.bus),
        }
    }

    /// Divider of the ticks, PRE_SCALE + 1.
    const fn divider(&self) -> u64 {
        self.prescale.get() as u64 + 1
    }

    /// The slowest that the boards' clock may be, Hz, rounded down.
    const fn slowest_hz(&self) -> u64 {
        let clock = self.prescale.clock();
        match clock.tolerance_ppm() {
            None => SLOWEST_HZ,
            Some(ppm) => clock.hz() as u64 * (MILLION - ppm as u64) / MILLION,
        }
    }

    /// Length of a tick at the slowest clock, picoseconds, rounded up.
    const fn tick_ps(&self) -> u64 {
        (self.divider() * 1_000_000_000_000).div_ceil(self.slowest_hz())
    }

    /// The widest pulse that is not longer than `ns` at the slowest clock; never a full period.
    pub(super) fn widest(&self, ns: u64) -> u16 {
        (ns.saturating_mul(1000) / self.tick_ps()).min(u64::from(Ticks::PER_PERIOD) - 1) as u16
    }

    /// Length of a period at the slowest clock, rounded up.
    pub(super) const fn period(&self) -> Duration {
        Duration::from_micros((self.tick_ps() * Ticks::PER_PERIOD as u64).div_ceil(1_000_000))
    }

    /// Shortest period, microseconds. An internal oscillator promises none.
    const fn shortest_us(&self) -> u64 {
        let clock = self.prescale.clock();
        match clock.tolerance_ppm() {
            None => 0,
            Some(ppm) => {
                let cycles = self.divider() * Ticks::PER_PERIOD as u64 * MILLION;
                cycles * MILLION / (clock.hz() as u64 * (MILLION + ppm as u64))
            }
        }
    }

    /// The most by which the bus delays switching wires off against switching one on.
    pub(super) fn switching(&self) -> Duration {
        SWITCHING + self.bus
    }

    /// Longest time from a command to the last edge it moves: the write, the end of the period in which it
    /// arrives, and the pulse's place in the next.
    pub(super) fn latency(&self) -> Duration {
        self.period() + self.period() + self.switching()
    }

    /// The longest that a channel may be on beyond its request, as its energy counts: one period and the bus.
    pub(super) fn surplus(&self) -> Duration {
        self.period() + self.switching()
    }

    /// Electrical energy, nJ, of pulses of `width` ticks for a `span`: from above over all clocks and phases.
    ///
    /// Each period of length T that starts within the span, lengthened by the bus to S, brings
    /// `I^2 R T width / 4096`, and `floor(S / T) + 1` can. At the slowest T that are n = ceil(S / T). A faster clock
    /// fits one more in only if T <= S / n: together they last at most (n + 1) S / n. Where no clock is that fast, n
    /// stays.
    pub(super) fn energy_nj(&self, width: u16, span: Duration) -> u64 {
        let span = (span + self.switching()).as_micros();
        let slowest = self.period().as_micros();
        let n = span.div_ceil(slowest);
        let mut on_us = n.saturating_mul(slowest);
        if span >= n.saturating_mul(self.shortest_us()) {
            on_us = on_us.max(span.saturating_add(span.div_ceil(n)));
        }
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

    /// Electrical energy, nJ, beyond the booking of a stimulus that ended `late`.
    ///
    /// On a clock of stated tolerance that is the excess of the whole span: the half period of [`Prescale::counted`]
    /// is not counted twice, and a host that is a little late costs nothing. On the internal oscillator the booking
    /// leaves open *when* within it pulses came, so the late part counts by itself.
    pub(super) fn late_nj(&self, width: u16, planned: Duration, late: Duration) -> u64 {
        if self.prescale.clock().tolerance_ppm().is_none() {
            return self.energy_nj(width, late);
        }
        let whole = self.energy_nj(width, planned + late);
        whole.saturating_sub(self.energy_nj(width, planned))
    }
}

#[cfg(test)]
#[path = "plant_tests.rs"]
mod tests;
