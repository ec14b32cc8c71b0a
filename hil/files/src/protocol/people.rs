//! People who answer where a study is simulated: the traits drawn for each participant, and their distributions.

use serde::Deserialize;

use super::super::error::FileError;
use super::super::settings::bounds;
use super::super::source::Source;

/// A value that differs from one participant to the next.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct Normal {
    /// Mean over all people.
    pub mean: f64,
    /// Standard deviation.
    pub sd: f64,
}

/// Thresholds of simulated people, and the traits of their answers.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct SimulatedThresholds {
    /// A participant's threshold, dB of full drive: the amplitude that 63 % of the time is more than a guess.
    pub threshold_db: Normal,
    /// Standard deviation of a wire from its participant, dB.
    pub wire_sd_db: f64,
    /// Slope of the Weibull function, per decade of amplitude.
    pub slope: Normal,
    /// Most slips of a participant, of all answers; they are drawn evenly from none to this.
    pub lapse: f64,
}

/// Just noticeable differences of simulated people.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct SimulatedDifferences {
    /// The part of the amplitude by which the stronger one has to differ, dB: -12 is a quarter.
    pub fraction_db: Normal,
    /// Slope of the Weibull function, per decade of that part.
    pub slope: Normal,
    /// Most slips of a participant, of all answers.
    pub lapse: f64,
}

/// Levels at which wires feel alike to simulated people.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct SimulatedMatches {
    /// Level, dB of full drive, at which a wire feels as strong as the reference.
    pub level_db: Normal,
    /// Slope of the Weibull function, per decade of amplitude.
    pub slope: Normal,
    /// Most slips of a participant, of all answers.
    pub lapse: f64,
}

/// Places at which simulated people point.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct SimulatedPlaces {
    /// Mean distance by which a participant points to the right of the place, mm; and as far up, drawn apart.
    pub bias_mm: Normal,
    /// Standard deviation of one answer, mm.
    pub noise_mm: f64,
    /// The part of answers that are anywhere on the display.
    pub slips: f64,
}

/// Drawings of simulated people.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct SimulatedDrawings {
    /// Distance of a participant's drawing to the right of the path, mm; and as far up, drawn apart.
    pub bias_mm: Normal,
    /// Factor by which a participant's drawing is larger.
    pub scale: Normal,
    /// Standard deviation of the hand around its line, mm; it wanders with a memory of 0.2 s.
    pub noise_mm: f64,
    /// Rate of breaks that the person marks and the path does not have, per second.
    pub breaks_hz: f64,
}

/// Ratings of simulated people.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct SimulatedRatings {
    /// A participant's rating of the first condition, before it is rounded to 1 to 6.
    pub rating: Normal,
    /// Standard deviation of one rating from its participant's.
    pub noise: f64,
    /// Excess of the second condition's rating in a comparison, where the question is how many people it takes to see
    /// it.
    pub difference: f64,
}

/// Choices of simulated people.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct SimulatedChoices {
    /// A participant's preference for the second condition of a pair, logits: 0 is none, 1 is 73 % of choices.
    pub preference: Normal,
}

impl Normal {
    pub(super) fn check(
        self,
        source: &Source,
        key: &str,
        range: (f64, f64),
    ) -> Result<(), FileError> {
        bounds!(source, key, self;
            mean: range.0..=range.1;
            sd: 0.0..=range.1 - range.0)
    }
}

/// Slopes and slips, as every task with two intervals has them.
fn answers(source: &Source, at: &str, slope: Normal, lapse: f64) -> Result<(), FileError> {
    slope.check(source, &format!("{at}.slope"), (0.5, 20.0))?;
    source.range(&format!("{at}.lapse"), &lapse, 0.0..=0.2, "")
}

impl SimulatedThresholds {
    pub(super) fn check(&self, source: &Source, at: &str) -> Result<(), FileError> {
        let threshold = self.threshold_db;
        threshold.check(source, &format!("{at}.threshold_db"), (-40.0, 0.0))?;
        bounds!(source, at, self; wire_sd_db: 0.0..=40.0, "dB")?;
        answers(source, at, self.slope, self.lapse)
    }
}

impl SimulatedDifferences {
    pub(super) fn check(&self, source: &Source, at: &str) -> Result<(), FileError> {
        let fraction = self.fraction_db;
        fraction.check(source, &format!("{at}.fraction_db"), (-30.0, 6.0))?;
        answers(source, at, self.slope, self.lapse)
    }
}

impl SimulatedMatches {
    pub(super) fn check(&self, source: &Source, at: &str) -> Result<(), FileError> {
        let level = self.level_db;
        level.check(source, &format!("{at}.level_db"), (-40.0, 0.0))?;
        answers(source, at, self.slope, self.lapse)
    }
}

impl SimulatedPlaces {
    pub(super) fn check(&self, source: &Source, at: &str) -> Result<(), FileError> {
        let bias = self.bias_mm;
        bias.check(source, &format!("{at}.bias_mm"), (-50.0, 50.0))?;
        bounds!(source, at, self;
            noise_mm: 0.0..=50.0, "mm";
            slips: 0.0..=1.0)
    }
}

impl SimulatedDrawings {
    pub(super) fn check(&self, source: &Source, at: &str) -> Result<(), FileError> {
        let (bias, scale) = (self.bias_mm, self.scale);
        bias.check(source, &format!("{at}.bias_mm"), (-50.0, 50.0))?;
        scale.check(source, &format!("{at}.scale"), (0.1, 10.0))?;
        bounds!(source, at, self;
            noise_mm: 0.0..=50.0, "mm";
            breaks_hz: 0.0..=10.0)
    }
}

impl SimulatedRatings {
    pub(super) fn check(&self, source: &Source, at: &str) -> Result<(), FileError> {
        let rating = self.rating;
        rating.check(source, &format!("{at}.rating"), (1.0, 6.0))?;
        bounds!(source, at, self;
            noise: 0.0..=5.0;
            difference: 0.0..=5.0)
    }
}

impl SimulatedChoices {
    pub(super) fn check(&self, source: &Source, at: &str) -> Result<(), FileError> {
        let preference = self.preference;
        preference.check(source, &format!("{at}.preference"), (-10.0, 10.0))
    }
}
