//! Staircases: down after a number of correct answers, up after a wrong one.

/// Steps, dB: the first until the level turns, the next until it turns again; the last one stays.
const STEPS: [f64; 3] = [8.0, 4.0, 2.0];
/// Correct answers in a row after which the level falls: 2 settles where 71 % are correct (Levitt 1971, table I).
const DOWN: u32 = 2;

/// A transformed up-down staircase (Levitt 1971, "Transformed up-down methods in psychoacoustics", J. Acoust. Soc. Am. 49,
/// 467). Until it first turns it falls after each correct answer, and so with the one that first turns it.
#[derive(Debug, Clone)]
pub struct Staircase {
    /// Least and most level, dB.
    range: (f64, f64),
    level: f64,
    /// Correct answers since the level last moved.
    streak: u32,
    rising: Option<bool>,
    /// Levels, dB, at which it turned.
    turns: Vec<f64>,
}

impl Staircase {
    /// A staircase at the most of its levels, least and most in dB.
    pub const fn new(range: (f64, f64)) -> Self {
        Self {
            level: range.1,
            range,
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
            true => first || self.streak >= DOWN,
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
        let step = STEPS[self.turns.len().min(STEPS.len() - 1)];
        let (least, most) = self.range;
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
