//! Counts of values in another unit: newtons, microtesla, volts.

use std::fmt;
use std::str::FromStr;

use super::number::Number;

/// Counts per unit and at 0: counts are `value * per_unit + at_zero`, rounded.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Gain {
    per_unit: f64,
    at_zero: f64,
}

/// Middle of the counts from 0 to 65535.
const MIDDLE: f64 = 32_768.0;
/// Most counts that values at rest may take: the others are for touches.
const ROOM: f64 = 1.75 * MIDDLE;
/// Least counts of noise: a threshold is found from it.
const NOISE: f64 = 3.0;
/// The gain of values without noise, such as a simulator's.
const WITHOUT_NOISE: f64 = 1000.0;

impl Gain {
    /// Counts are `value * per_unit + at_zero`.
    pub(super) const fn new(per_unit: f64, at_zero: f64) -> Self {
        Self { per_unit, at_zero }
    }

    /// Turns the gain for values of an axis that may count the other way.
    pub(super) fn turned(self, is_opposite: bool) -> Self {
        let sign = if is_opposite { -1.0 } else { 1.0 };
        Self::new(self.per_unit * sign, self.at_zero)
    }

    pub(super) fn counts(self, value: f64) -> f64 {
        value * self.per_unit + self.at_zero
    }

    /// The values that counts can stand for, as errors name them.
    pub(super) fn range(self) -> String {
        let value = |counts: f64| (counts - self.at_zero) / self.per_unit;
        let (least, most) = (
            value(0.0).min(value(65_535.0)),
            value(0.0).max(value(65_535.0)),
        );
        format!("a value from {least:.3} to {most:.3} (--gain makes counts of it)")
    }

    /// Accepts counts, which need no gain; for other values the error proposes a gain by their noise.
    ///
    /// # Errors
    /// The expectation and the finding, where most values are no counts.
    pub(super) fn needless(rows: &[Vec<String>], places: &[usize]) -> Result<(), (String, String)> {
        let Some((gain, shown)) = Self::needed(rows, places) else {
            return Ok(());
        };
        let expected = format!(
            "whole counts from 0 to 65535 (--gain {gain} makes counts of values by their noise: COUNTS per unit, and at 0)"
        );
        Err((expected, format!("values such as `{shown}`")))
    }

    /// The gain by which the noise of values comes to a few counts, and one of the values; none where most are counts.
    pub(super) fn needed(rows: &[Vec<String>], places: &[usize]) -> Option<(Self, String)> {
        let field = |row: &Vec<String>, place: usize| row.get(place).cloned().unwrap_or_default();
        let (mut steps, mut no_counts, mut all) = (Vec::new(), 0, 0);
        let (mut least, mut most) = (f64::INFINITY, f64::NEG_INFINITY);
        let mut shown = String::new();
        for &place in places {
            let mut before: Option<f64> = None;
            for row in rows {
                let text = field(row, place);
                let Some(value) = text.parse::<f64>().ok().filter(|v| v.is_finite()) else {
                    return None; // reading it will say where
                };
                all += 1;
                (least, most) = (least.min(value), most.max(value));
                if u16::read(&text).is_none() {
                    no_counts += 1;
                    shown = text;
                }
                steps.extend(
                    before
                        .map(|before| (value - before).abs())
                        .filter(|step| *step > 0.0),
                );
                before = Some(value);
            }
        }
        if no_counts * 2 <= all {
            return None;
        }
        steps.sort_unstable_by(f64::total_cmp);
        let gain = Self::proposed(steps.get(steps.len() / 2).copied(), least, most);
        Some((gain, shown))
    }

    /// Counts per unit and at 0.
    pub(super) const fn parts(self) -> (f64, f64) {
        (self.per_unit, self.at_zero)
    }

    /// A power of ten by which noise comes to a few counts, and which leaves room for touches.
    fn proposed(noise: Option<f64>, least: f64, most: f64) -> Self {
        let tens = |log: f64| libm::pow(10.0, log);
        let by_noise = noise.map_or(WITHOUT_NOISE, |noise| {
            tens(libm::ceil(libm::log10(NOISE / noise)))
        });
        let by_span = tens(libm::floor(libm::log10(ROOM / (most - least))));
        let per_unit = by_noise.min(by_span);
        let at_zero = if most.max(-least) * per_unit <= MIDDLE / 2.0 {
            MIDDLE
        } else if least >= 0.0 && most * per_unit <= ROOM {
            0.0
        } else {
            libm::round(MIDDLE - (least + most) / 2.0 * per_unit)
        };
        Self { per_unit, at_zero }
    }
}

impl fmt::Display for Gain {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}:{}", self.per_unit, self.at_zero)
    }
}

impl FromStr for Gain {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let (per_unit, at_zero) = text.split_once(':').unwrap_or((text, "0"));
        let number = |text: &str| text.parse().ok().filter(|v: &f64| v.is_finite());
        match (number(per_unit), number(at_zero)) {
            (Some(per_unit), Some(at_zero)) if per_unit.abs() > 0.0 => {
                Ok(Self { per_unit, at_zero })
            }
            _ => Err("expected counts per unit, other than 0, and at 0, such as 100:32768".into()),
        }
    }
}

#[cfg(test)]
#[path = "gain_tests.rs"]
mod tests;
