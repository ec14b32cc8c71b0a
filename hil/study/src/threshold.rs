//! The absolute threshold of one wire, between two intervals: levels by QUEST+ or by a staircase, and in both cases what
//! the answers say about it.

use palpate_files::ThresholdMethod;

use crate::quest::{Estimate, Quest, QuestDomain};
use crate::staircase::{Staircase, StaircaseSettings};

/// Least level, dB of full drive.
pub(crate) const LEAST_DB: f64 = -40.0;
/// Correct answers without a stimulus: one of two intervals has it.
pub(crate) const GUESS: f64 = 0.5;
/// Slips that estimates count with.
const LAPSE: f64 = 0.02;

/// Trials of one wire and what they say.
#[derive(Debug, Clone)]
pub struct Thresholding {
    quest: Quest,
    staircase: Option<Staircase>,
    left: u32,
}

impl Thresholding {
    /// So many trials, at levels from -40 dB to 0 dB of full drive, 1 dB apart.
    pub fn new(method: ThresholdMethod, trials: u32) -> Self {
        let levels = (LEAST_DB as i32..=0).map(f64::from);
        let domain = QuestDomain {
            levels: levels.collect(),
            thresholds: (2 * LEAST_DB as i32..=0)
                .map(|half| f64::from(half) / 2.0)
                .collect(),
            slopes: vec![2.0, 3.5, 5.0],
            guess: GUESS,
            lapse: LAPSE,
        };
        let staircase = StaircaseSettings {
            start: 0.0,
            steps: vec![8.0, 4.0, 2.0],
            down: 2,
            range: (LEAST_DB, 0.0),
            turns: usize::MAX, // the number of trials ends it
        };
        Self {
            quest: Quest::flat(domain),
            staircase: (method == ThresholdMethod::Staircase).then(|| Staircase::new(staircase)),
            left: trials,
        }
    }

    /// The level of the next trial, dB of full drive; `None` after the last one.
    pub fn next(&self) -> Option<f64> {
        let level = || match &self.staircase {
            Some(staircase) => staircase.next(),
            None => Some(self.quest.next()),
        };
        (self.left > 0).then(level).flatten()
    }

    /// Takes the answer to a trial at this level in.
    pub fn answer(&mut self, level: f64, correct: bool) {
        self.left = self.left.saturating_sub(1);
        self.quest.answer(level, correct);
        if let Some(staircase) = &mut self.staircase {
            staircase.answer(correct);
        }
    }

    /// The threshold, dB of full drive, with its 95 % interval.
    pub fn threshold(&self) -> Estimate {
        self.quest.threshold()
    }
}
