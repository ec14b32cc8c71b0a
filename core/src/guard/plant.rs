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
mod tests {
    use super::*;

    const PLANT: Plant = Plant {
        prescale: Prescale::new(30),
        wire_milliohm: 1900,
        peak: Milliamps(1970),
    };

    #[test]
    fn times_are_those_of_the_slowest_oscillator() {
        // 31 / 23 MHz = 1.3478 us; 4096 of them are 5.5207 ms.
        assert_eq!(PLANT.tick_ps(), 1_347_827);
        assert_eq!(PLANT.period().as_micros(), 5521);
        assert_eq!(PLANT.surplus().as_micros(), 6521);
        assert_eq!(PLANT.latency().as_micros(), 12_042);
    }

    #[test]
    fn the_widest_pulse_is_never_a_period() {
        for (ns, ticks) in [
            (0, 0),
            (1_347, 0),
            (1_348, 1),
            (200_000, 148),
            (u64::MAX, 4095),
        ] {
            assert_eq!(PLANT.widest(ns), ticks, "{ns} ns");
        }
    }

    #[test]
    fn energy_is_that_of_the_most_pulses_any_oscillator_fits_in() {
        // I^2 R / 4096 of a tick's width: 7.373_710 W / 4096.
        let watts = 7.373_71 / 4096.0;
        // 36 ms are 6.52 slowest periods: 7 of 5.521 ms, or 8 of at most 36 / 7 ms.
        for (span_us, on_us) in [
            (35_000, 41_143),
            (5_521, 11_042),
            (4_521, 11_042),
            (4_520, 11_040),
            (10_100, 16_563),
            (0, 5_521),
        ] {
            let exact = watts * 100.0 * f64::from(on_us) * 1e3;
            let counted = PLANT.energy_nj(100, Duration::from_micros(span_us)) as f64;
            assert!(
                (counted - exact).abs() < 2.0 + 1e-6 * exact,
                "{span_us}: {counted} {exact}"
            );
        }
        assert_eq!(PLANT.energy_nj(0, Duration::from_millis(35)), 0);
        // Full on for a quarter of an hour: beyond what one multiplication holds.
        let long = PLANT.energy_nj(4096, Duration::from_micros(1_000_000_000)) as f64;
        assert!((long / 7_373.71e9 - 1.0).abs() < 1e-4, "{long}");
        assert_eq!(
            PLANT.energy_nj(4096, Duration::from_micros(u64::MAX)),
            u64::MAX / 4
        );
    }

    /// Counted one by one over oscillators and phases.
    #[test]
    fn no_oscillator_and_no_phase_delivers_more() {
        for span_us in (500..50_000).step_by(499) {
            let counted = PLANT.energy_nj(4096, Duration::from_micros(span_us));
            for hz in (23_000_000..=27_400_000).step_by(20_000) {
                let period_us = 4096.0 * 31.0 / f64::from(hz) * 1e6;
                let starts = libm::floor((span_us + 1000) as f64 / period_us) + 1.0;
                let delivered = 7.373_71 * starts * period_us * 1e3;
                assert!(delivered <= counted as f64 + 1.0, "{span_us} us at {hz} Hz");
            }
        }
    }

    #[test]
    fn implausible_plants_are_refused() {
        for (wire_milliohm, peak, good) in [
            (1, 1, true),
            (1_000_000, 100_000, true),
            (0, 1, false),
            (1_000_001, 1, false),
            (1, 0, false),
            (1, 100_001, false),
        ] {
            let plant = Plant {
                wire_milliohm,
                peak: Milliamps(peak),
                ..PLANT
            };
            assert_eq!(plant.check().is_ok(), good);
        }
        assert!(alloc::format!("{}", PlantError::OutOfRange).contains("1 to 100000 mA"));
    }
}
