//! Pulses of a burst: their number, their spacing, and the time between bursts.
//!
//! All pulses of a board are one PWM period apart, whichever wire they are for. Few large pulses are felt better than many
//! small ones of the same energy (`docs/felt.md`), so a burst has as few as a vibration takes.
//!
//! Between bursts all outputs of a board are off, and its counter is held at zero (PCA9685 data sheet 7.3.3): the first period
//! begins with the onset. A channel that goes off in the middle of period n has had n pulses, at any oscillator from 23 to
//! 27.4 MHz and up to four pulses. Up to three it may go off at a quarter: at 23 MHz the third begins 2.17 periods in.

use crate::guard::BURST_GAP;
use crate::illusion::LONGEST;
use crate::schedule::Timing;
use crate::units::{Duration, Prescale};

/// Bursts on one wire that begin this much after the end of another are bursts of their own, whatever the bus does.
const APART: Duration = Duration::from_micros(BURST_GAP.as_micros() + 1200);
/// Shortest burst that feels like a vibration and not like a tap:
/// 30 ms (Remache-Vinueza 2025), and a hundredth more for rounding.
const VIBRATION_US: u64 = 30_300;
/// Pulses of a tap, and the fewest that are no tap.
const TAP: u8 = 2;
const SMOOTH: u8 = 3;
/// Pulses that may go off at a quarter, whatever the oscillator.
const QUARTERS: u8 = 3;
/// Most pulses of a burst that are tried.
const MOST: u8 = 9;
/// Time between bursts where nothing is stated: apparent motion on a fingerpad wants 105 to 125 ms.
pub const CADENCE: Duration = Duration::from_millis(117);

/// Pulses of a burst, their spacing and the time between bursts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Pattern {
    prescale: Prescale,
    smooth: u8,
    soa: Duration,
    off: Off,
}

/// Point of the last pulse's period at which a channel goes off.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Off {
    /// Half of the period: as far from the next pulse as from the last one.
    Middle,
    /// A quarter of the period, where the pause before the next burst needs the rest.
    Quarter,
}

/// Bursts come too often for two pulses and the pause after which a burst is a new one.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("more time between onsets: two pulses and a pause of {} ms must fit in", APART.as_micros() as f64 * 1e-3)]
pub struct PatternError;

impl Pattern {
    /// The fewest pulses, at least `least`, that make a vibration where the display has the boards' spacing to itself.
    ///
    /// # Errors
    /// Onsets that come too often.
    pub fn new(soa: Duration, least: u8) -> Result<Self, PatternError> {
        let longest = longest(soa);
        let spaced = |pulses: u8| {
            let period_us = VIBRATION_US.div_ceil(u64::from(pulses) - 1);
            let steps = (period_us * 1000).div_ceil(Prescale::new(3).period_ns() / 4);
            let prescale = Prescale::new((steps - 1).min(255) as u8);
            let ends = [Off::Middle, Off::Quarter];
            ends.map(|off| Self {
                prescale,
                smooth: pulses,
                soa,
                off,
            })
        };
        let fits = |p: &Self| {
            let counted = p.off == Off::Middle || p.smooth <= QUARTERS;
            counted && p.timing().duration <= longest
        };
        let vibration = (least.max(SMOOTH)..=MOST).flat_map(spaced).find(fits);
        if let Some(pattern) = vibration {
            return Ok(pattern);
        }
        // No vibration fits in: as many pulses as make the longest burst.
        let halves = 2 * u64::from(least.max(SMOOTH)) - 1;
        let period_ns = longest.as_micros() * 2000 / halves;
        let steps = period_ns / (Prescale::new(3).period_ns() / 4);
        let prescale = Prescale::new(steps.saturating_sub(1).min(255) as u8);
        Self::on(prescale, soa)
    }

    /// The fewest pulses that make a vibration on boards whose spacing another has chosen; else as many as fit in.
    ///
    /// # Errors
    /// Onsets that come too often.
    pub fn on(prescale: Prescale, soa: Duration) -> Result<Self, PatternError> {
        let longest = longest(soa);
        let enough = 1 + (VIBRATION_US * 1000).div_ceil(prescale.period_ns());
        let half = prescale.period_ns() / 2;
        let fit = (longest.as_micros() * 1000 / half).div_ceil(2);
        let smooth = enough.min(fit).min(u64::from(u8::MAX)) as u8;
        match smooth >= TAP {
            true => Ok(Self {
                prescale,
                smooth,
                soa,
                off: Off::Middle,
            }),
            false => Err(PatternError),
        }
    }

    /// PRE_SCALE of the boards.
    pub const fn prescale(&self) -> Prescale {
        self.prescale
    }

    /// Length of a vibration's bursts and the time between onsets.
    pub const fn timing(&self) -> Timing {
        Timing {
            duration: self.lasts(self.smooth),
            soa: self.soa,
        }
    }

    /// Pulses of a burst: of a tap, or of a vibration.
    pub const fn pulses(&self, tap: bool) -> u8 {
        if tap { TAP } else { self.smooth }
    }

    /// Time for which a channel is on for this many pulses: it goes off within the last one's period.
    pub const fn lasts(&self, pulses: u8) -> Duration {
        let quarters = match self.off {
            Off::Middle => 2,
            Off::Quarter => 1,
        };
        let quarters = (4 * (pulses as u64)).saturating_sub(4 - quarters);
        Duration::from_micros(quarters * self.prescale.period_ns() / 4000)
    }
}

/// The longest burst that leaves the pause before the next.
fn longest(soa: Duration) -> Duration {
    let room = soa.as_micros().saturating_sub(APART.as_micros());
    Duration::from_micros(room).min(LONGEST)
}

#[cfg(test)]
#[path = "pattern_tests.rs"]
mod tests;
