//! Taps where a surface is met and where it is left: pulses on all wires that die away, as contact transients are
//! rendered. A harder surface answers with denser and stronger ones.

use crate::units::{Duration, Instant, Prescale};

/// Longest tap: the guard's longest burst less a period.
const LENGTH: Duration = Duration::from_micros(44_900);
/// Nanoseconds times millihertz in one period.
const WHOLE: u64 = 1_000_000_000_000;

/// A figure of taps at both ends of hardness.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Firmness<T> {
    /// Figure for the softest surface.
    pub soft: T,
    /// Figure for the hardest surface.
    pub hard: T,
}

/// Settings of taps.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Taps {
    /// Pulses per second, millihertz; at most the carrier's.
    pub rate_mhz: Firmness<u32>,
    /// Strength of the first pulse, as a share of the strongest that the guard allows: of its amplitude where the renderer
    /// finds widths, of its width for a published law. Short and seldom, a tap may be far stronger than a texture that goes
    /// on and on.
    pub strength: Firmness<f32>,
    /// Time in which the strength falls to 1/e.
    pub decay: Duration,
}

/// One tap.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Tap {
    start: Instant,
    period_ns: u64,
    /// Periods from pulse to pulse.
    step: u64,
    strength: f32,
    decay: Duration,
    /// The period of the next pulse.
    period: u64,
}

impl Tap {
    /// Tap of a surface of this hardness, 0 to 1, that begins at `start`.
    pub(super) fn new(taps: &Taps, start: Instant, hardness: f64, carrier: Prescale) -> Self {
        let hardness = hardness.clamp(0.0, 1.0);
        let between = |soft: f64, hard: f64| soft + (hard - soft) * hardness;
        let Firmness { soft, hard } = taps.rate_mhz;
        let rate_mhz = between(f64::from(soft), f64::from(hard)).max(1.0) as u64;
        let Firmness { soft, hard } = taps.strength;
        let period_ns = carrier.period_ns();
        Self {
            start,
            period_ns,
            step: ((WHOLE / rate_mhz + period_ns / 2) / period_ns).max(1),
            strength: between(f64::from(soft), f64::from(hard)) as f32,
            decay: taps.decay,
            period: 0,
        }
    }

    /// Time from the tap's start to the start of a period.
    fn since(&self, period: u64) -> Duration {
        Duration::from_micros(period * self.period_ns / 1000)
    }

    /// Start of the tap's next pulse; never once the tap is over.
    pub(super) fn next(&self) -> Instant {
        if self.since(self.period + 1) > LENGTH {
            return Instant::FAR_FUTURE;
        }
        self.start + self.since(self.period)
    }

    /// Beginning of the pulse that is due, and its strength as a share of the strongest. Pulses are on for `length`; one
    /// that was missed is left out.
    pub(super) fn due(&mut self, now: Instant, length: Duration) -> Option<(Instant, f32)> {
        while self.next() <= now {
            let since = self.since(self.period);
            let at = self.start + since;
            self.period += self.step;
            if at + length > now {
                let gone = since.as_micros() as f32 / self.decay.as_micros().max(1) as f32;
                let share = self.strength * libm::expf(-gone);
                return Some((at, share));
            }
        }
        None
    }
}

#[cfg(test)]
#[path = "tap_tests.rs"]
mod tests;
