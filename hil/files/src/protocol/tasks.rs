//! The tasks that a participant can be given.

use serde::{Deserialize, Serialize};

use super::super::error::FileError;
use super::super::settings::bounds;
use super::super::source::Source;
use super::super::words::choice;
use super::people::{
    SimulatedChoices, SimulatedDifferences, SimulatedDrawings, SimulatedMatches, SimulatedPlaces,
    SimulatedRatings, SimulatedThresholds,
};

choice! { /** Methods that choose the level of the next trial. */ ThresholdMethod {
    /// QUEST+ (Watson 2017): the level whose answer tells most.
    QuestPlus = "quest-plus",
    /// A staircase, one up and two down (Levitt 1971).
    Staircase = "staircase",
} }

choice! { /** Rules by which participants meet the conditions of a comparison. */ Groups {
    /// Every participant meets every condition.
    Within = "within",
    /// Odd participants meet the first condition of each compared pair, even ones the second.
    Between = "between",
} }

palpate_core::listed! {
    /// A task, by its name in files and data.
    #[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
    #[serde(rename_all = "snake_case")]
    pub enum TaskKind: name {
        /// The least that is felt.
        AbsoluteThreshold = "absolute_threshold",
        /// The least difference that is felt.
        Difference = "difference",
        /// Wires that feel alike.
        Matching = "matching",
        /// The place that was felt.
        Localisation = "localisation",
        /// The path that was felt.
        Drawing = "drawing",
        /// Ratings from 1 to 6.
        Rating = "rating",
        /// The choice between two conditions.
        Choice = "choice",
    }
}

/// Threshold task: which of two intervals had the stimulus? It finds the least that is felt, for each wire.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct ThresholdTask {
    /// Wires, counted from zero.
    pub wires: Vec<u16>,
    /// The method that chooses the level of the next trial.
    pub method: ThresholdMethod,
    /// Trials for each wire.
    pub trials: u32,
    /// The people who answer in a simulation.
    pub simulated: SimulatedThresholds,
}

/// Difference task: which of two intervals was stronger? It finds the least difference from a level that is felt, for
/// each wire.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct DifferenceTask {
    /// Wires, counted from zero.
    pub wires: Vec<u16>,
    /// The level that both intervals have at least, dB of full drive: -12 leaves room for three times as much again.
    pub level_db: f64,
    /// The method that chooses the difference of the next trial.
    pub method: ThresholdMethod,
    /// Trials for each wire.
    pub trials: u32,
    /// The people who answer in a simulation.
    pub simulated: SimulatedDifferences,
}

/// Matching task: which of two wires was stronger? It finds the level at which each feels as strong as the reference.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct MatchTask {
    /// The wire that the others are matched to, counted from zero.
    pub reference: u16,
    /// Level of the reference, dB of full drive.
    pub level_db: f64,
    /// Wires that are matched, counted from zero.
    pub wires: Vec<u16>,
    /// Trials for each wire.
    pub trials: u32,
    /// The people who answer in a simulation.
    pub simulated: SimulatedMatches,
}

/// Localisation task: where was it? The participant points at the place.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct LocateTask {
    /// Wires, counted from zero.
    pub wires: Vec<u16>,
    /// Level, dB of full drive.
    pub level_db: f64,
    /// Number of times that each wire comes.
    pub repeats: u32,
    /// The people who answer in a simulation.
    pub simulated: SimulatedPlaces,
}

/// Drawing task: the participant draws the path that was felt.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct DrawTask {
    /// Names of conditions with a scene.
    pub conditions: Vec<String>,
    /// Number of times that each condition comes.
    pub repeats: u32,
    /// The people who answer in a simulation.
    pub simulated: SimulatedDrawings,
}

/// Rating task: how rough, slippery or hard is it, from 1 to 6?
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct RatingTask {
    /// Scales of the rating, each with the meanings of 1 and 6.
    pub scales: Vec<RatingScale>,
    /// Names of conditions.
    pub conditions: Vec<String>,
    /// Pairs of conditions whose ratings are compared by Mann and Whitney's U.
    pub compare: Vec<[String; 2]>,
    /// The rule by which participants meet the conditions of a comparison.
    pub groups: Groups,
    /// Ratings of each condition by a participant; their mean counts.
    pub repeats: u32,
    /// The people who answer in a simulation.
    pub simulated: SimulatedRatings,
}

/// A scale from 1 to 6.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct RatingScale {
    /// The scale in one word: the name of a column.
    pub name: String,
    /// Meaning of 1.
    pub low: String,
    /// Meaning of 6.
    pub high: String,
}

/// Choice task: which of two?
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct ChoiceTask {
    /// The question, such as "Which one moved more smoothly?".
    pub question: String,
    /// Pairs of conditions; which of a pair comes first is drawn, as often one as the other.
    pub pairs: Vec<[String; 2]>,
    /// Number of times that each pair comes.
    pub repeats: u32,
    /// The people who answer in a simulation.
    pub simulated: SimulatedChoices,
}

/// Checks the wires of a task: at least one, each once.
fn check_wires(source: &Source, task: &str, wires: &[u16]) -> Result<(), FileError> {
    if wires.is_empty() {
        return Err(source.bad(&format!("{task}.wires"), "one wire at least"));
    }
    for (index, wire) in wires.iter().enumerate() {
        let key = format!("{task}.wires[{index}]");
        source.range(&key, wire, 0..=255, "")?;
        if wires[..index].contains(wire) {
            return Err(source.bad(&key, "each wire once"));
        }
    }
    Ok(())
}

fn check_level(source: &Source, task: &str, level_db: f64) -> Result<(), FileError> {
    let key = format!("{task}.level_db");
    source.range(&key, &level_db, -40.0..=0.0, "dB of full drive")
}

/// Checks a number of trials; a larger one is a slip of the keyboard.
fn check_count(source: &Source, key: &str, count: u32) -> Result<(), FileError> {
    source.range(key, &count, 1..=1000, "")
}

/// Checks that a sentence is not empty.
pub(super) fn check_text(source: &Source, key: &str, text: &str) -> Result<(), FileError> {
    match text.trim().is_empty() {
        true => Err(source.bad(key, "a word or a sentence")),
        false => Ok(()),
    }
}

/// Checks that a name can be that of a column.
pub(super) fn check_word(source: &Source, key: &str, word: &str) -> Result<(), FileError> {
    let of_a_word = |c: char| c.is_ascii_lowercase() || c == '_';
    match !word.is_empty() && word.chars().all(of_a_word) {
        true => Ok(()),
        false => Err(source.bad(key, "a word of lower-case letters")),
    }
}

impl ThresholdTask {
    pub(super) fn check(&self, source: &Source) -> Result<(), FileError> {
        let task = "absolute_threshold";
        check_wires(source, task, &self.wires)?;
        check_count(source, &format!("{task}.trials"), self.trials)?;
        self.simulated.check(source, &format!("{task}.simulated"))
    }
}

impl DifferenceTask {
    pub(super) fn check(&self, source: &Source) -> Result<(), FileError> {
        let task = "difference";
        check_wires(source, task, &self.wires)?;
        check_level(source, task, self.level_db)?;
        if self.level_db > -3.0 {
            let key = format!("{task}.level_db");
            return Err(source.bad(&key, "at most -3 dB: the other interval is stronger"));
        }
        check_count(source, &format!("{task}.trials"), self.trials)?;
        self.simulated.check(source, &format!("{task}.simulated"))
    }
}

impl MatchTask {
    pub(super) fn check(&self, source: &Source) -> Result<(), FileError> {
        let task = "matching";
        check_wires(source, task, &self.wires)?;
        bounds!(source, task, self; reference: 0..=255)?;
        if let Some(index) = self.wires.iter().position(|wire| *wire == self.reference) {
            let key = format!("{task}.wires[{index}]");
            return Err(source.bad(&key, "another wire than the reference"));
        }
        check_level(source, task, self.level_db)?;
        check_count(source, &format!("{task}.trials"), self.trials)?;
        self.simulated.check(source, &format!("{task}.simulated"))
    }
}

impl LocateTask {
    pub(super) fn check(&self, source: &Source) -> Result<(), FileError> {
        let task = "localisation";
        check_wires(source, task, &self.wires)?;
        check_level(source, task, self.level_db)?;
        check_count(source, &format!("{task}.repeats"), self.repeats)?;
        self.simulated.check(source, &format!("{task}.simulated"))
    }
}

impl DrawTask {
    pub(super) fn check(&self, source: &Source) -> Result<(), FileError> {
        check_count(source, "drawing.repeats", self.repeats)?;
        self.simulated.check(source, "drawing.simulated")
    }
}

impl RatingTask {
    pub(super) fn check(&self, source: &Source) -> Result<(), FileError> {
        if self.scales.is_empty() {
            return Err(source.bad("rating.scales", "one scale at least"));
        }
        for (index, scale) in self.scales.iter().enumerate() {
            let at = |key: &str| format!("rating.scales[{index}].{key}");
            check_word(source, &at("name"), &scale.name)?;
            if self.scales[..index].iter().any(|s| s.name == scale.name) {
                return Err(source.bad(&at("name"), "each scale once"));
            }
            check_text(source, &at("low"), &scale.low)?;
            check_text(source, &at("high"), &scale.high)?;
        }
        for (index, pair) in self.compare.iter().enumerate() {
            for (side, name) in pair.iter().enumerate() {
                if !self.conditions.contains(name) {
                    let key = format!("rating.compare[{index}][{side}]");
                    return Err(source.bad(&key, "one of rating.conditions"));
                }
            }
            if pair[0] == pair[1] {
                let key = format!("rating.compare[{index}]");
                return Err(source.bad(&key, "two conditions that differ"));
            }
        }
        check_count(source, "rating.repeats", self.repeats)?;
        self.simulated.check(source, "rating.simulated")
    }
}

impl ChoiceTask {
    pub(super) fn check(&self, source: &Source) -> Result<(), FileError> {
        check_text(source, "choice.question", &self.question)?;
        if self.pairs.is_empty() {
            return Err(source.bad("choice.pairs", "one pair at least"));
        }
        for (index, [first, second]) in self.pairs.iter().enumerate() {
            if first == second {
                let key = format!("choice.pairs[{index}]");
                return Err(source.bad(&key, "two conditions that differ"));
            }
        }
        check_count(source, "choice.repeats", self.repeats)?;
        self.simulated.check(source, "choice.simulated")
    }
}
