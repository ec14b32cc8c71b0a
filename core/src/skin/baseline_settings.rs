//! Settings of the baseline and the reasons for which they are refused.

use super::relative::Axes;
use crate::units::Duration;

/// Rules that give the contact threshold, raw counts.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ThresholdRule {
    /// The largest |difference| of any chosen axis of any taxel in the first frame after the reference (4.3),
    /// plus a margin.
    Auto {
        /// Counts added to that value.
        margin: f32,
    },
    /// A threshold for each taxel: `floor` and so many times its noise at rest, measured while the reference is made
    /// and without the rows that merely repeat. One frame with an outlier cannot raise it for all.
    PerTaxel {
        /// Standard deviations (Euclidean over the chosen axes).
        sigmas: f32,
        /// Counts added to them: fainter changes do not matter.
        floor: f32,
    },
    /// A threshold given in counts.
    Fixed {
        /// The threshold, counts.
        counts: f32,
    },
}

/// Settings of the baseline.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BaselineSettings {
    /// T: frames in the reference, at least 1.
    pub reference_frames: u32,
    /// A taxel is faulty when an axis is further than this many standard deviations (over all taxels, population
    /// form) from that axis's mean on the initial frame; `None` keeps all. Over n taxels no value can be further
    /// than sqrt(n - 1) deviations: 3.87 for n = 16.
    pub fault_sigmas: Option<f32>,
    /// The contact threshold.
    pub threshold: ThresholdRule,
    /// The axes that count for threshold, contact and intensity.
    pub axes: Axes,
    /// Time constant with which the reference follows the drift of untouched taxels. With it the reference is a
    /// state: it has to be found at rest, and a taxel is let go below a lower limit than its threshold. `None` keeps
    /// the reference and one threshold as they were found.
    pub drift: Option<Duration>,
}

impl Default for BaselineSettings {
    /// Settings of the thesis: 10 frames, no taxel faulty, the threshold of (4.3) without margin, all axes, no drift
    /// following.
    fn default() -> Self {
        Self {
            reference_frames: 10,
            fault_sigmas: None,
            threshold: ThresholdRule::Auto { margin: 0.0 },
            axes: Axes::XYZ,
            drift: None,
        }
    }
}

/// Reasons for which settings are refused.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum BaselineError {
    /// A reference of no frames, T = 0.
    #[error("the reference needs at least one frame")]
    NoReference,
    /// A number of deviations that is not positive and finite.
    #[error("the number of standard deviations must be positive and finite")]
    BadSigmas,
    /// A margin, threshold or number of deviations that is NaN, infinite or negative.
    #[error("threshold and margin must be finite and not negative")]
    BadThreshold,
    /// A time constant of zero.
    #[error("the time constant of drift must be longer than 0")]
    BadDrift,
}

impl BaselineSettings {
    /// Counts and standard deviations of the threshold, once every setting is checked.
    pub(super) fn checked(&self) -> Result<(f32, f32), BaselineError> {
        if self.reference_frames == 0 {
            return Err(BaselineError::NoReference);
        }
        if self
            .fault_sigmas
            .is_some_and(|k| !(k > 0.0 && k.is_finite()))
        {
            return Err(BaselineError::BadSigmas);
        }
        let (counts, sigmas) = match self.threshold {
            ThresholdRule::Auto { margin } => (margin, 0.0),
            ThresholdRule::Fixed { counts } => (counts, 0.0),
            ThresholdRule::PerTaxel { sigmas, floor } => (floor, sigmas),
        };
        if [counts, sigmas]
            .iter()
            .any(|v| !(*v >= 0.0 && v.is_finite()))
        {
            return Err(BaselineError::BadThreshold);
        }
        if self.drift == Some(Duration::ZERO) {
            return Err(BaselineError::BadDrift);
        }
        Ok((counts, sigmas))
    }
}
