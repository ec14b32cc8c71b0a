//! The times of a recording: clocks that jump, and numbers that are no microseconds.

use std::str::FromStr;

use palpate_core::statistics::quantile;

/// Longest recording, as the longest scene: a slip in a time must not make a run of years.
pub const LONGEST_US: u64 = 86_400_000_000;
/// Further apart, two rows are no longer one recording: the clock was set between them.
const JUMP_US: u64 = 3_600_000_000;
/// Frames of several buses may be this much out of order.
pub const DISORDER_US: u64 = 1_000_000;
/// Steps that tell what a column counts.
const TELLING: usize = 16;
/// A row per second and slower, by its numbers: they may be nanoseconds.
const SLOW_US: u64 = 1_000_000;

/// What a column of times counts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TimeUnit {
    /// Seconds.
    S,
    /// Milliseconds.
    Ms,
    /// Microseconds.
    Us,
    /// Nanoseconds.
    Ns,
}

/// A column that says when, as `--time COLUMN[:UNIT]` names it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct TimeColumn {
    /// Its heading.
    pub name: String,
    /// What it counts.
    pub unit: TimeUnit,
}

impl FromStr for TimeColumn {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let (name, unit) = text.rsplit_once(':').unwrap_or((text, "us"));
        let unit = match unit {
            "s" => TimeUnit::S,
            "ms" => TimeUnit::Ms,
            "us" => TimeUnit::Us,
            "ns" => TimeUnit::Ns,
            _ => return Err("expected a column and s, ms, us or ns, such as timestamp:ms".into()),
        };
        match name {
            "" => Err("expected a column, such as timestamp:ms".into()),
            name => Ok(Self {
                name: name.to_owned(),
                unit,
            }),
        }
    }
}

impl TimeUnit {
    /// A field as microseconds, rounded.
    pub(super) fn micros(self, field: &str) -> Option<u64> {
        let whole = field.parse::<u64>().ok();
        match (self, whole) {
            (Self::Us, Some(us)) => return Some(us),
            (Self::Ms, Some(ms)) => return ms.checked_mul(1000),
            (Self::S, Some(s)) => return s.checked_mul(1_000_000),
            (Self::Ns, Some(ns)) => return Some(ns / 1000),
            (_, None) => {}
        }
        let us_per_unit = match self {
            Self::S => 1e6,
            Self::Ms => 1e3,
            Self::Us => 1.0,
            Self::Ns => 1e-3,
        };
        let us = field.parse::<f64>().ok()? * us_per_unit;
        // Below 2^63 every rounded value has a place.
        (0.0..9.2e18).contains(&us).then(|| us.round() as u64)
    }

    /// As messages name it.
    pub(super) const fn noun(self) -> &'static str {
        match self {
            Self::S => "seconds",
            Self::Ms => "milliseconds",
            Self::Us => "microseconds",
            Self::Ns => "nanoseconds",
        }
    }
}

/// Why a time cannot follow those before it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct OutOfTime {
    /// What was expected.
    pub expected: String,
    /// What was found; none: the field as it stands.
    pub found: Option<String>,
}

/// Follows the times of a recording, in microseconds.
#[derive(Clone, Debug, Default)]
pub struct Times {
    /// Whether jumps are taken out.
    split: bool,
    first: Option<u64>,
    last: Option<u64>,
    /// What is added to the times of the piece that is read, to follow the piece before.
    shift: i128,
    /// The usual distance, as far as it is known.
    step: u64,
    steps: Vec<u64>,
    notes: Vec<String>,
}

/// A length of time in the unit that people would say it in.
fn length(us: u64) -> String {
    let s = us as f64 * 1e-6;
    match s {
        s if s >= 2.0 * 31_557_600.0 => format!("{:.1} years", s / 31_557_600.0),
        s if s >= 2.0 * 86_400.0 => format!("{:.1} days", s / 86_400.0),
        s if s >= 3600.0 => format!("{:.1} hours", s / 3600.0),
        s => format!("{s:.3} s"),
    }
}

impl Times {
    /// Times from the first on; `split` takes jumps of the clock out.
    #[must_use]
    pub fn new(split: bool) -> Self {
        Self {
            split,
            ..Self::default()
        }
    }

    /// The time of the next row, later than the row before.
    ///
    /// # Errors
    /// A time that is not later, a jump of the clock, a recording of more than a day.
    pub fn row(&mut self, place: &str, us: u64) -> Result<u64, OutOfTime> {
        self.next(place, us, Some(1))
    }

    /// The time of the next row, no earlier than the row before: clocks of milliseconds repeat themselves.
    ///
    /// # Errors
    /// As [`Times::row`].
    pub fn coarse_row(&mut self, place: &str, us: u64) -> Result<u64, OutOfTime> {
        self.next(place, us, Some(0))
    }

    /// The time of the next frame, which may be a little earlier than the one before.
    ///
    /// # Errors
    /// A jump of the clock, a recording of more than a day.
    pub fn frame(&mut self, place: &str, us: u64) -> Result<u64, OutOfTime> {
        self.next(place, us, None)
    }

    /// Rows are at least `least` microseconds apart; frames may be out of order.
    fn next(&mut self, place: &str, us: u64, least: Option<i128>) -> Result<u64, OutOfTime> {
        let mut shifted = i128::from(us) + self.shift;
        if let Some(last) = self.last {
            let by = shifted - i128::from(last);
            let jumped = by > i128::from(JUMP_US) || by < -i128::from(DISORDER_US);
            if jumped && self.split {
                let to = i128::from(last) + i128::from(self.step.max(1));
                self.shift += to - shifted;
                shifted = to;
                let first = self.first.unwrap_or(0);
                // Frames count from a whole second.
                let zero = match least {
                    Some(_) => first,
                    None => first - first % 1_000_000,
                };
                self.notes.push(format!(
                    "{place}: {} taken out: a new piece, joined at {:.3} s of the run",
                    jump(by),
                    (shifted - i128::from(zero)) as f64 * 1e-6
                ));
            } else if jumped && (by > 0 || least.is_none()) {
                return Err(OutOfTime {
                    expected: format!(
                        "a time near the one before, {last} us (--split-jumps plays what follows right after it)"
                    ),
                    found: Some(jump(by)),
                });
            } else if least.is_some_and(|least| by < least) {
                let before = i128::from(last) - self.shift;
                let more = if least == Some(0) { "no less" } else { "more" };
                let expected = format!("{more} than the row before, {before}");
                return Err(OutOfTime {
                    expected,
                    found: None,
                });
            } else if by > 0 {
                let step = u64::try_from(by).unwrap_or(u64::MAX);
                self.step = step;
                if self.steps.len() < TELLING {
                    self.steps.push(step);
                }
            }
        }
        let first = *self.first.get_or_insert(us);
        if shifted - i128::from(first) > i128::from(LONGEST_US) {
            return Err(OutOfTime {
                expected: format!("at most a day after the first, {first} us"),
                found: None,
            });
        }
        // A frame may come a little before the first one.
        let time = u64::try_from(shifted).unwrap_or(0);
        self.last = Some(self.last.map_or(time, |last| last.max(time)));
        Ok(time)
    }

    /// Whether enough rows have come to tell what their numbers are.
    pub(super) fn is_telling(&self) -> bool {
        self.steps.len() == TELLING
    }

    /// What a column of whole microseconds looks like instead: its rows come too fast or too slow for a skin.
    pub(super) fn looks_like(&self) -> Option<String> {
        let mut steps = self.steps.clone();
        steps.sort_unstable();
        let median = quantile(&steps, 0.5)?.above;
        if steps.len() < 2 {
            return None;
        }
        let every = |us: u64| length(us);
        match median {
            1 => Some("row numbers: give --rate HZ, and leave the column out".into()),
            SLOW_US.. => Some(format!(
                "nanoseconds: they would be rows every {}",
                every(median)
            )),
            _ => None,
        }
    }

    /// The jumps that were taken out, with their places.
    pub fn take_notes(&mut self) -> Vec<String> {
        std::mem::take(&mut self.notes)
    }
}

fn jump(by: i128) -> String {
    let us = u64::try_from(by.unsigned_abs()).unwrap_or(u64::MAX);
    let way = if by < 0 { "back" } else { "ahead" };
    format!("a jump of the clock, {} {way}", length(us))
}

#[cfg(test)]
#[path = "times_tests.rs"]
mod tests;
