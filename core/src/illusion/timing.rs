//! Timing of stimuli: onset asynchrony and duration.

use crate::listed::listed;
use crate::schedule::Timing;
use crate::units::Duration;

/// Longest stimulus that a law asks for: what the guard passes whole of its longest burst, 50 ms from the first
/// edge to the last, less a pulse and the bus (0.2 ms and 1 ms).
pub const LONGEST: Duration = Duration::from_micros(48_800);
/// Duration where neither it nor an onset asynchrony is stated (thesis chapter 5).
const USUAL: Duration = Duration::from_millis(35);

listed! {
    /// Study by which the missing one of duration and onset asynchrony is found.
    #[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
    pub enum TimingLaw: name {
        /// `SOA = 0.32 tau_d + 47.3 ms` (Israr and Poupyrev 2011, Tactile Brush), found on the back.
        #[default]
        TactileBrush = "tactile-brush",
        /// 115 ms between onsets, the middle of the 105 to 125 ms at which a fingerpad mostly felt motion.
        Fingerpad = "fingerpad",
    }
}

impl TimingLaw {
    /// Checks a timing; the law gives the part that is not stated, durations not above [`LONGEST`].
    ///
    /// # Errors
    /// [`TimingError`] for a zero span, or stimuli longer than the time to the next.
    pub fn timing(
        self,
        duration: Option<Duration>,
        soa: Option<Duration>,
    ) -> Result<Timing, TimingError> {
        let soa = soa.unwrap_or(match self {
            Self::TactileBrush => soa_tactile_brush(duration.unwrap_or(USUAL)),
            Self::Fingerpad => Duration::from_millis(115),
        });
        let duration = duration.unwrap_or(duration_tactile_brush(soa).min(LONGEST));
        if duration == Duration::ZERO || soa == Duration::ZERO {
            return Err(TimingError::Zero);
        }
        if duration > soa {
            return Err(TimingError::Overlap);
        }
        Ok(Timing { duration, soa })
    }
}

/// Onset asynchrony for apparent motion: `0.32 tau_d + 47.3 ms` (Israr and Poupyrev 2011, Tactile Brush),
/// in whole microseconds: 35 ms -> 58.5 ms.
const fn soa_tactile_brush(duration: Duration) -> Duration {
    Duration::from_micros(duration.as_micros().saturating_mul(32) / 100 + 47_300)
}

/// Duration of a stimulus by the Tactile Brush law, from its onset asynchrony; zero where onsets are too close for it.
pub(super) const fn duration_tactile_brush(soa: Duration) -> Duration {
    Duration::from_micros(soa.as_micros().saturating_sub(47_300).saturating_mul(100) / 32)
}

/// Reasons for which a timing is refused.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum TimingError {
    /// A stimulus of no length, or onsets no time apart; under 47.3 ms the law leaves no time to vibrate.
    #[error(
        "a stimulus duration above zero, or more than 47.3 ms between onsets for the law to give one"
    )]
    Zero,
    /// Stimuli would overlap their successors: d <= SOA is required (Park 2016).
    #[error("a stimulus not longer than the time between onsets, tau_d <= tau_SOA")]
    Overlap,
}

#[cfg(test)]
#[path = "timing_tests.rs"]
mod tests;
