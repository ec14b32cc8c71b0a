//! Levels of trials with two intervals, by QUEST+ or by a staircase, and the estimate from the answers: the absolute
//! threshold of a wire, the least difference, the level at which two wires feel alike.

use palpate_files::ThresholdMethod;

use crate::quest::{Estimate, Quest, QuestDomain};
use crate::staircase::Staircase;

/// Least level, dB of full drive.
pub(crate) const LEAST_DB: f64 = -40.0;
/// Correct answers without a stimulus: one of two intervals has it.
pub(crate) const GUESS: f64 = 0.5;
/// Rate of slips that estimates assume.
const LAPSE: f64 = 0.02;
/// Range of differences that estimates cover, as parts of the lesser amplitude, dB.
pub(crate) const FRACTIONS_DB: (f64, f64) = (-30.0, 6.0);
/// The part of the way from no to yes at which two wires feel alike.
pub(crate) const ALIKE: f64 = 0.5;

/// Levels of trials, and the estimate from their answers.
#[derive(Debug, Clone)]
pub struct Thresholding {
    quest: Quest,
    staircase: Option<Staircase>,
    left: u32,
}

/// Whole numbers of decibels from `from` to `to`.
fn decibels(from: f64, to: f64) -> Vec<f64> {
    (from as i32..=to as i32).map(f64::from).collect()
}

/// Numbers from `from` to `to`, 0.5 apart.
fn halves(from: f64, to: f64) -> Vec<f64> {
    let whole = 2 * from as i32..=2 * to as i32;
    whole.map(|half| f64::from(half) / 2.0).collect()
}

impl Thresholding {
    /// The absolute threshold of a wire, in so many trials at levels from -40 dB to 0 dB of full drive, 1 dB apart.
    #[must_use]
    pub fn absolute(method: ThresholdMethod, trials: u32) -> Self {
        let domain = QuestDomain {
            levels: decibels(LEAST_DB, 0.0),
            thresholds: halves(LEAST_DB, 0.0),
            slopes: vec![2.0, 3.5, 5.0],
            guess: GUESS,
            lapse: LAPSE,
            part: 1.0 - libm::exp(-1.0),
        };
        Self::new(method, domain, trials)
    }

    /// The least difference from a level, dB of full drive, that is felt: its levels are parts of that amplitude, from
    /// -30 dB to the rest below full drive, 6 dB at most.
    #[must_use]
    pub fn difference(method: ThresholdMethod, trials: u32, level_db: f64) -> Self {
        let room = 20.0 * libm::log10(libm::pow(10.0, -level_db / 20.0) - 1.0);
        let (least, most) = FRACTIONS_DB;
        let domain = QuestDomain {
            levels: decibels(least, libm::floor(room).clamp(least, most)),
            thresholds: halves(least, most),
            slopes: vec![1.0, 2.0, 3.5],
            guess: GUESS,
            lapse: LAPSE,
            part: 1.0 - libm::exp(-1.0),
        };
        Self::new(method, domain, trials)
    }

    /// The level, dB of full drive, at which a wire is called stronger than another as often as weaker.
    #[must_use]
    pub fn matching(trials: u32) -> Self {
        let domain = QuestDomain {
            levels: decibels(LEAST_DB, 0.0),
            thresholds: halves(LEAST_DB, 0.0),
            slopes: vec![2.0, 3.5, 5.0, 8.0],
            guess: LAPSE,
            lapse: LAPSE,
            part: ALIKE,
        };
        Self::new(ThresholdMethod::QuestPlus, domain, trials)
    }

    fn new(method: ThresholdMethod, domain: QuestDomain, trials: u32) -> Self {
        let ends = (domain.levels.first(), domain.levels.last());
        let range = (
            ends.0.copied().unwrap_or_default(),
            ends.1.copied().unwrap_or_default(),
        );
        Self {
            staircase: (method == ThresholdMethod::Staircase).then(|| Staircase::new(range)),
            quest: Quest::new(domain),
            left: trials,
        }
    }

    /// The level of the next trial, dB; `None` after the last one.
    #[must_use]
    pub fn next(&self) -> Option<f64> {
        let level = || match &self.staircase {
            Some(staircase) => staircase.next(),
            None => self.quest.next(),
        };
        (self.left > 0).then(level)
    }

    /// The largest level that a trial may have, dB.
    #[must_use]
    pub fn most(&self) -> f64 {
        self.quest.most()
    }

    /// Takes the answer to a trial at this level in: whether it was correct, or of two wires that this one was stronger.
    pub fn answer(&mut self, level: f64, yes: bool) {
        self.left = self.left.saturating_sub(1);
        self.quest.answer(level, yes);
        if let Some(staircase) = &mut self.staircase {
            staircase.answer(yes);
        }
    }

    /// The threshold, dB, with its 95 % interval.
    #[must_use]
    pub fn threshold(&self) -> Estimate {
        self.quest.threshold()
    }
}
