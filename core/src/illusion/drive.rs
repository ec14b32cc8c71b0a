//! Duty from activation: intensity levels, the person's calibration, (5.1).

use alloc::boxed::Box;
use alloc::vec;

use crate::physics::FULL_DRIVE_DUTY;
use crate::units::Ticks;

/// Spacing of the weights of intensity levels between the weakest and 1.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Steps {
    /// Even spacing.
    #[default]
    Even,
    /// Spacing by just noticeable differences down from the top: each level is weaker by the Weber fraction, and
    /// levels that would fall below the weakest weight share it.
    Weber(f32),
}

/// Duty from activation, (5.1) with intensity: `A = alpha + beta g a` for a > 0, else off.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Drive {
    /// Duty offset, a fraction of a period; raises only wires that are active.
    pub alpha: f32,
    /// Duty range, a fraction of a period (thesis: 100 / 4096).
    pub beta: f32,
    /// Weight g of the weakest intensity level, in (0, 1]; 1 is the thesis's constant beta.
    pub floor: f32,
    /// Spacing of the levels between.
    pub steps: Steps,
}

impl Default for Drive {
    /// Full drive is 100 of 4096 ticks, the weakest level 0.85 of it, the levels between evenly spaced.
    fn default() -> Self {
        Self {
            alpha: 0.0,
            beta: FULL_DRIVE_DUTY as f32,
            floor: 0.85,
            steps: Steps::Even,
        }
    }
}

impl Drive {
    /// g(level): monotone, 1 at the top level.
    pub fn weight(&self, level: u16, levels: u16) -> f32 {
        if levels <= 1 {
            return 1.0;
        }
        let level = level.clamp(1, levels);
        match self.steps {
            Steps::Even => {
                let part = f32::from(level - 1) / f32::from(levels - 1);
                self.floor + (1.0 - self.floor) * part
            }
            Steps::Weber(fraction) => {
                let below = f32::from(levels - level);
                libm::expf(-below * libm::log1pf(fraction)).max(self.floor)
            }
        }
    }

    /// Pulse width for an activation already weighted by g.
    pub fn width(&self, activation: f32) -> Ticks {
        if activation > 0.0 {
            Ticks::from_duty(self.alpha + self.beta * activation)
        } else {
            Ticks::ZERO
        }
    }
}

/// Needs of one person by wire: gain and threshold. All wires of a person who has not been measured have the same.
#[derive(Clone, Debug, PartialEq)]
pub struct Calibration {
    wires: Box<[(f32, f32)]>,
}

/// Reasons for which a calibration is refused.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum CalibrationError {
    /// Gains and thresholds that are not one of each per wire.
    #[error("one gain and one threshold a wire")]
    Count,
    /// A gain that is not above 0 and at most 1, by its wire: the strongest wire has gain 1, others are lowered to it.
    #[error("a gain above 0 and at most 1 (full scale)")]
    Gain(usize),
    /// A threshold that is not from 0 to below 1, by its wire: what is not felt at full drive cannot be driven.
    #[error("a threshold from 0 to below the wire's gain")]
    Threshold(usize),
}

impl Calibration {
    /// Calibration of wires that are all alike: gain 1, threshold 0.
    pub fn even(wires: usize) -> Self {
        Self {
            wires: vec![(1.0, 0.0); wires].into(),
        }
    }

    /// Calibration from a gain and a threshold per wire. The gain is the drive, as a part of full drive, at which all
    /// wires feel equally strong. The threshold is the part of full drive at which this person begins to feel the wire.
    ///
    /// # Errors
    /// [`CalibrationError`] names the wire.
    pub fn new(gain: &[f32], threshold: &[f32]) -> Result<Self, CalibrationError> {
        if gain.len() != threshold.len() {
            return Err(CalibrationError::Count);
        }
        for (i, (&g, &t)) in gain.iter().zip(threshold).enumerate() {
            if !(g > 0.0 && g <= 1.0) {
                return Err(CalibrationError::Gain(i));
            }
            if !(0.0..g).contains(&t) {
                return Err(CalibrationError::Threshold(i));
            }
        }
        let wires = gain.iter().copied().zip(threshold.iter().copied());
        Ok(Self {
            wires: wires.collect(),
        })
    }

    /// Number of wires.
    pub fn len(&self) -> usize {
        self.wires.len()
    }

    /// Tells whether there is no wire.
    pub fn is_empty(&self) -> bool {
        self.wires.is_empty()
    }

    /// The part of full drive at which this wire feels as strong as the others do at theirs.
    pub fn gain(&self, wire: usize) -> f32 {
        self.wires.get(wire).map_or(1.0, |(gain, _)| *gain)
    }

    /// The activation that this person needs for a weighted activation of a wire: 0 stays 0, everything
    /// above lies between the threshold and the gain.
    pub fn apply(&self, wire: usize, activation: f32) -> f32 {
        match self.wires.get(wire) {
            Some(&(gain, threshold)) if activation > 0.0 => {
                threshold + (gain - threshold) * activation
            }
            _ => 0.0,
        }
    }
}

#[cfg(test)]
#[path = "drive_tests.rs"]
mod tests;
