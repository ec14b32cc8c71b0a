//! Staircases: down after a number of correct answers, up after a wrong one.

/// Parameters of a staircase.
#[derive(Debug, Clone, PartialEq)]
pub struct StaircaseSettings {
    /// Level of the first trial, dB.
    pub start: f64,
    /// Steps, dB: the first until the level turns, the next until it turns again; the last one stays.
    pub steps: Vec<f64>,
    /// Correct answers in a row after which the level falls: 2 settles where 71 % are correct (Levitt 1971, table I).
    pub down: u32,
    /// Least and most level, dB.
    pub range: (f64, f64),
}

/// A transformed up-down staircase (Levitt 1971, "Transformed up-down methods in psychoacoustics", J. Acoust. Soc. Am. 49,
/// 467). Until it first turns it falls after each correct answer, and so with the one that first turns it.
#[derive(Debug, Clone)]
pub struct Staircase {
    settings: StaircaseSettings,
    level: f64,
    /// Correct answers since the level last moved.
    streak: u32,
    rising: Option<bool>,
    /// Levels, dB, at which it turned.
    turns: Vec<f64>,
}

impl Staircase {
    /// A staircase at its start.
    pub fn new(settings: StaircaseSettings) -> Self {
        let (least, most) = settings.range;
        Self {
            level: settings.start.min(most).max(least),
            settings,
            streak: 0,
            rising: None,
            turns: Vec::new(),
        }
    }

    /// The level of the next trial, dB.
    pub const fn next(&self) -> f64 {
        self.level
    }

    /// Takes the answer to the last level in.
    pub fn answer(&mut self, correct: bool) {
        let first = self.turns.is_empty();
        self.streak = if correct { self.streak + 1 } else { 0 };
        let moves = match correct {
            true => first || self.streak >= self.settings.down,
            false => true,
        };
        if !moves {
            return;
        }
        let rising = !correct;
        if self.rising.is_some_and(|before| before != rising) {
            self.turns.push(self.level);
        }
        self.rising = Some(rising);
        let steps = &self.settings.steps;
        let last = steps.len().saturating_sub(1);
        let step = steps
            .get(self.turns.len().min(last))
            .copied()
            .unwrap_or(1.0);
        let (least, most) = self.settings.range;
        let level = if rising {
            self.level + step
        } else {
            self.level - step
        };
        self.level = level.min(most).max(least);
        self.streak = 0;
    }
}

#[cfg(test)]
#[path = "staircase_tests.rs"]
mod tests;
