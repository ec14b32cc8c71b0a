//! Protocols of studies with people: what a participant is asked, and who answers where a study is simulated.

use serde::Deserialize;

use super::error::FileError;
use super::source::Source;
use super::words::choice;

choice! { /** How the level of the next trial is chosen. */ ThresholdMethod {
    /// QUEST+ (Watson 2017): the level whose answer tells most.
    QuestPlus = "quest-plus",
    /// A staircase, one up and two down (Levitt 1971).
    Staircase = "staircase",
} }

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

/// Which of two intervals had the stimulus? The least that is felt, for each wire.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct ThresholdTask {
    /// Wires, counted from zero.
    pub wires: Vec<u16>,
    /// How the level of the next trial is chosen.
    pub method: ThresholdMethod,
    /// Trials for each wire.
    pub trials: u32,
    /// The people who answer in a simulation.
    pub simulated: SimulatedThresholds,
}

/// Thresholds of simulated people, and how they answer.
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

/// How rough, slippery or hard is it, from 1 to 6? Half of the participants rate one condition, half the other.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct RatingTask {
    /// What is rated.
    pub question: String,
    /// The two conditions that are compared.
    pub conditions: [String; 2],
    /// Ratings of a participant; their mean counts.
    pub repeats: u32,
    /// The people who answer in a simulation.
    pub simulated: SimulatedRatings,
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
    /// How much higher the second condition is rated where the question is how many people it takes to see it.
    pub difference: f64,
}

/// A study.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct Protocol {
    /// Lower case with hyphens.
    pub name: String,
    /// What it finds out, in a sentence.
    pub description: String,
    /// Which values are neither published nor measured; results flag it.
    pub assumed: Option<String>,
    /// The absolute threshold of each wire.
    pub absolute_threshold: Option<ThresholdTask>,
    /// A rating in two conditions.
    pub rating: Option<RatingTask>,
}

impl Normal {
    fn check(self, source: &Source, key: &str, range: (f64, f64)) -> Result<(), FileError> {
        source.range(&format!("{key}.mean"), self.mean, range.0..=range.1, "")?;
        source.range(&format!("{key}.sd"), self.sd, 0.0..=range.1 - range.0, "")
    }
}

impl ThresholdTask {
    fn check(&self, source: &Source) -> Result<(), FileError> {
        if self.wires.is_empty() {
            return Err(source.bad("absolute_threshold.wires", "one wire at least"));
        }
        for (index, wire) in self.wires.iter().enumerate() {
            let key = format!("absolute_threshold.wires[{index}]");
            source.range(&key, *wire, 0..=255, "")?;
            if self.wires[..index].contains(wire) {
                return Err(source.bad(&key, "each wire once"));
            }
        }
        source.range("absolute_threshold.trials", self.trials, 1..=1000, "")?;
        let people = &self.simulated;
        let at = |key: &str| format!("absolute_threshold.simulated.{key}");
        let db = (-40.0, 0.0);
        people.threshold_db.check(source, &at("threshold_db"), db)?;
        source.range(&at("wire_sd_db"), people.wire_sd_db, 0.0..=40.0, "dB")?;
        people.slope.check(source, &at("slope"), (0.5, 20.0))?;
        source.range(&at("lapse"), people.lapse, 0.0..=0.2, "")
    }
}

impl RatingTask {
    fn check(&self, source: &Source) -> Result<(), FileError> {
        for (key, text) in [
            ("rating.question", &self.question),
            ("rating.conditions[0]", &self.conditions[0]),
            ("rating.conditions[1]", &self.conditions[1]),
        ] {
            if text.trim().is_empty() {
                return Err(source.bad(key, "a word or a sentence"));
            }
        }
        if self.conditions[0] == self.conditions[1] {
            return Err(source.bad("rating.conditions", "two conditions that differ"));
        }
        source.range("rating.repeats", self.repeats, 1..=1000, "")?;
        let people = &self.simulated;
        let at = |key: &str| format!("rating.simulated.{key}");
        people.rating.check(source, &at("rating"), (1.0, 6.0))?;
        source.range(&at("noise"), people.noise, 0.0..=5.0, "")?;
        source.range(&at("difference"), people.difference, 0.0..=5.0, "")
    }
}

impl Protocol {
    /// Reads and checks a protocol.
    ///
    /// # Errors
    /// Names the line and key of what cannot be.
    pub fn read(source: &Source) -> Result<Self, FileError> {
        let file: Self = source.read()?;
        source.heading(&file.name, &file.description)?;
        if let Some(task) = &file.absolute_threshold {
            task.check(source)?;
        }
        if let Some(task) = &file.rating {
            task.check(source)?;
        }
        if file.absolute_threshold.is_none() && file.rating.is_none() {
            let expected = "[absolute_threshold] or [rating]: a study has a task";
            return Err(source.bad_found("", expected, "none"));
        }
        Ok(file)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn refused(change: (&str, &str)) -> String {
        let text = palpate_fixtures::protocol("thresholds").unwrap();
        assert!(text.contains(change.0), "{}", change.0);
        let source = Source::new("t.toml", text.replacen(change.0, change.1, 1));
        Protocol::read(&source).unwrap_err().to_string()
    }

    #[test]
    fn what_is_no_study_is_refused_with_its_key() {
        for (change, key, expected) in [
            (
                ("wires = [0, 1", "wires = [0, 0"),
                "absolute_threshold.wires[1]",
                "each wire once",
            ),
            (
                ("trials = 60", "trials = 0"),
                "absolute_threshold.trials",
                "1 to 1000",
            ),
            (
                ("mean = -14.0", "mean = 3.0"),
                "absolute_threshold.simulated.threshold_db.mean",
                "-40 to 0",
            ),
            (
                ("lapse = 0.04", "lapse = nan"),
                "absolute_threshold.simulated.lapse",
                "a finite number",
            ),
            (
                ("quest-plus", "quest"),
                "absolute_threshold.method",
                "quest-plus",
            ),
        ] {
            let said = refused(change);
            assert!(said.contains(key) && said.contains(expected), "{said}");
        }
    }
}
