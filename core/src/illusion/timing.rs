//! When stimuli start and how long they last.

use core::fmt;

use crate::schedule::Timing;
use crate::units::Duration;

/// Onset asynchrony for apparent motion: `0.32 tau_d + 47.3 ms` (Israr & Poupyrev 2011, Tactile
/// Brush), in whole microseconds: 35 ms -> 58.5 ms.
pub const fn soa_tactile_brush(duration: Duration) -> Duration {
    Duration::from_micros(duration.as_micros().saturating_mul(32) / 100 + 47_300)
}

/// Why a timing is refused.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TimingError {
    /// A stimulus of no length, or onsets no time apart.
    Zero,
    /// Stimuli would overlap their successors: d <= SOA is required (Park 2016).
    Overlap,
}

impl fmt::Display for TimingError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Zero => "expected a stimulus duration and an onset asynchrony above zero",
            Self::Overlap => {
                "the stimulus lasts longer than the onset asynchrony; expected tau_d <= tau_SOA"
            }
        })
    }
}

impl core::error::Error for TimingError {}

/// A checked timing; without `soa` the Tactile Brush law gives it.
///
/// # Errors
/// [`TimingError`] for a zero span, or stimuli longer than the time to the next.
pub fn timing(duration: Duration, soa: Option<Duration>) -> Result<Timing, TimingError> {
    let soa = soa.unwrap_or(soa_tactile_brush(duration));
    if duration == Duration::ZERO || soa == Duration::ZERO {
        return Err(TimingError::Zero);
    }
    if duration > soa {
        return Err(TimingError::Overlap);
    }
    Ok(Timing { duration, soa })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn thirty_five_milliseconds_give_58_5() {
        let t = timing(Duration::from_millis(35), None).unwrap();
        assert_eq!(t.soa, Duration::from_micros(58_500));
    }

    #[test]
    fn overlap_starts_just_under_70_ms() {
        // d <= 0.32 d + 47.3 ms exactly when d <= 69.56 ms (anchors.md: Park 2016).
        assert!(timing(Duration::from_micros(69_558), None).is_ok());
        assert_eq!(
            timing(Duration::from_micros(69_560), None),
            Err(TimingError::Overlap)
        );
        assert_eq!(timing(Duration::ZERO, None), Err(TimingError::Zero));
    }
}
