//! Division of a stimulus's level into width and current.

use super::Stimulus;
use crate::units::{Instant, Milliamps, Ticks};

/// Division of a level into width and current: down to a width a level has less width, below it less current.
/// Amplifiers of one current have less width alone.
///
/// Both bring the same energy: a tenth of a width of few ticks is lost to the rise of the current and to whole ticks, a tenth
/// of a current is not.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Share {
    /// Current of a stimulus that is not below that width.
    pub peak: Milliamps,
    /// Narrowest pulse; zero for amplifiers of one current.
    pub narrowest: Ticks,
}

impl Share {
    /// Share for amplifiers that have one current.
    pub const fn width(peak: Milliamps) -> Self {
        Self {
            peak,
            narrowest: Ticks::ZERO,
        }
    }

    /// Width and current of a stimulus that would have this width at the full current, with no wire and no time yet. It brings
    /// no more energy than that.
    #[must_use]
    pub fn stimulus(&self, width: Ticks) -> Stimulus {
        let (wanted, least) = (width.get(), self.narrowest.get());
        let peak = match (1..least).contains(&wanted) {
            // Energy goes with the square of the current.
            true => {
                let part = libm::sqrt(f64::from(wanted) / f64::from(least));
                Milliamps((f64::from(self.peak.0) * part) as u32)
            }
            false => self.peak,
        };
        Stimulus {
            wire: 0,
            width: match wanted {
                0 => width,
                _ => width.max(self.narrowest),
            },
            peak,
            at: Instant::ZERO,
            until: Instant::ZERO,
        }
    }
}

#[cfg(test)]
#[path = "share_tests.rs"]
mod tests;
