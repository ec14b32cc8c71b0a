//! Stimuli of a trial, its question, and the answers to it.

use palpate_files::{RatingScale, TaskKind};
use serde::{Deserialize, Serialize};

/// Longest drawing, points: ten minutes at 120 Hz.
const MOST_POINTS: usize = 72_000;
/// Farthest from the display's middle that a person can point, mm.
const FARTHEST_MM: f64 = 500.0;

/// Stimulus of one interval of a trial.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Stimulus {
    /// No wire is driven, for as long as one would be.
    Silence,
    /// One wire.
    Wire {
        /// Counted from zero.
        wire: u16,
        /// Level of the wire, dB of full drive.
        level_db: f64,
    },
    /// One of the protocol's conditions.
    Condition(String),
}

/// Question to a participant after a trial.
#[derive(Debug, Clone, PartialEq)]
pub enum Ask {
    /// The interval with the stimulus, or with the stronger one: the question.
    Interval(&'static str),
    /// The protocol's own question about the two intervals.
    Which(String),
    /// The place of the stimulus.
    Place,
    /// A drawing of the path.
    Path,
    /// A number from 1 to 6 on each scale.
    Ratings(Vec<RatingScale>),
}

/// A point of a drawing.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Sample {
    /// Milliseconds since the drawing began.
    pub t_ms: f64,
    /// Distance to the right of the display's middle, mm.
    pub x_mm: f64,
    /// Distance above the display's middle, mm.
    pub y_mm: f64,
}

/// Answer of a participant.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum Answer {
    /// The first (1) or the second (2) interval.
    Interval(u8),
    /// A place on the display, mm.
    Place([f64; 2]),
    /// A drawing: between its strokes the person marked breaks.
    Path(Vec<Vec<Sample>>),
    /// A number from 1 to 6 for each scale, in the protocol's order.
    Ratings(Vec<u8>),
}

/// A trial as it has to be played.
#[derive(Debug, Clone, PartialEq)]
pub struct Trial {
    /// Number of the trial, from 1 on; practice counts.
    pub number: u32,
    /// Number of earlier beginnings of the trial that came to nothing.
    pub attempt: u32,
    /// Task of the trial.
    pub task: TaskKind,
    /// `true` for practice, whose answer does not count.
    pub practice: bool,
    /// Stimuli of the intervals, one after the other.
    pub intervals: Vec<Stimulus>,
    /// Question after the intervals.
    pub ask: Ask,
    /// The interval that is the right answer, where there is one; for `matching` and `choice` the one whose choice counts
    /// as yes.
    pub right: Option<u8>,
    /// The level that the method chose: dB of full drive, of `difference` the difference as a part of the lesser one, dB.
    pub level_db: Option<f64>,
}

/// Errors of an answer to a trial.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum AnswerError {
    /// Another kind of answer than was asked for.
    #[error("expected {expected}, found {found}")]
    Kind {
        /// The expected answer, in words.
        expected: String,
        /// The answer found, in words.
        found: String,
    },
    /// A reply that fits no open question.
    #[error("expected {0}")]
    Step(&'static str),
}

impl Answer {
    const fn name(&self) -> &'static str {
        match self {
            Self::Interval(_) => "an interval",
            Self::Place(_) => "a place",
            Self::Path(_) => "a drawing",
            Self::Ratings(_) => "ratings",
        }
    }
}

impl Ask {
    /// Checks that this is an answer to the question.
    ///
    /// # Errors
    /// The expected answer, in words.
    pub fn check(&self, answer: &Answer) -> Result<(), AnswerError> {
        let bad = |expected: String, found: String| Err(AnswerError::Kind { expected, found });
        let near = |mm: f64| mm.is_finite() && mm.abs() <= FARTHEST_MM;
        match (self, answer) {
            (Self::Interval(_) | Self::Which(_), Answer::Interval(chosen)) => {
                match (1..=2).contains(chosen) {
                    true => Ok(()),
                    false => bad("interval 1 or 2".into(), chosen.to_string()),
                }
            }
            (Self::Place, Answer::Place([x, y])) => match near(*x) && near(*y) {
                true => Ok(()),
                false => bad(
                    format!("a place within {FARTHEST_MM} mm"),
                    format!("{x}, {y}"),
                ),
            },
            (Self::Path, Answer::Path(strokes)) => {
                let points: usize = strokes.iter().map(Vec::len).sum();
                if points == 0 || points > MOST_POINTS || strokes.iter().any(Vec::is_empty) {
                    return bad(
                        format!("strokes of 1 to {MOST_POINTS} points"),
                        points.to_string(),
                    );
                }
                let times = strokes.iter().flatten().map(|s| s.t_ms);
                let on = times.clone().zip(times.skip(1)).all(|(a, b)| a <= b);
                let all = strokes.iter().flatten();
                let whole = on
                    && all
                        .clone()
                        .all(|s| near(s.x_mm) && near(s.y_mm) && (0.0..1e9).contains(&s.t_ms));
                match whole {
                    true => Ok(()),
                    false => bad(
                        "points in order of time, on the display".into(),
                        "others".into(),
                    ),
                }
            }
            (Self::Ratings(scales), Answer::Ratings(ratings)) => {
                let fits =
                    ratings.len() == scales.len() && ratings.iter().all(|r| (1..=6).contains(r));
                match fits {
                    true => Ok(()),
                    false => bad(
                        format!("{} numbers from 1 to 6", scales.len()),
                        format!("{ratings:?}"),
                    ),
                }
            }
            (ask, answer) => bad(ask.wants().into(), answer.name().into()),
        }
    }

    const fn wants(&self) -> &'static str {
        match self {
            Self::Interval(_) | Self::Which(_) => "an interval",
            Self::Place => "a place",
            Self::Path => "a drawing",
            Self::Ratings(_) => "ratings",
        }
    }
}
