//! Protocols of studies with people: the questions and their order, and the people who answer where a study is
//! simulated.

mod people;
mod tasks;

pub use people::{
    Normal, SimulatedChoices, SimulatedDifferences, SimulatedDrawings, SimulatedMatches,
    SimulatedPlaces, SimulatedRatings, SimulatedThresholds,
};
pub use tasks::{
    ChoiceTask, DifferenceTask, DrawTask, Groups, LocateTask, MatchTask, RatingScale, RatingTask,
    TaskKind, ThresholdMethod, ThresholdTask,
};

use serde::Deserialize;

use super::error::FileError;
use super::near::did_you_mean;
use super::overrides::Overrides;
use super::settings::bounds;
use super::source::Source;
use super::words::choice;
use tasks::{check_text, check_word};

/// Most trials of a session: more than a day of them is a slip of the keyboard.
const MOST_TRIALS: u64 = 5000;

choice! { /** Orders of conditions. */ Order {
    /// Each condition once, shuffled; then all of them once more, shuffled anew.
    Blocks = "blocks",
    /// All repeats of all conditions, shuffled together.
    Shuffle = "shuffle",
    /// Rows of a Latin square in which each condition follows each other one equally often (Williams 1949); participants and
    /// repeats take its rows in turn.
    LatinSquare = "latin-square",
    /// The file's order, over and over.
    AsListed = "as-listed",
} }

/// A condition that a participant meets in a trial.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct Condition {
    /// The condition's name in the data; participants never see it.
    pub name: String,
    /// The scene that is played: a built-in name or a file.
    pub scene: Option<String>,
    /// The scene's illusion, in place of its own.
    pub illusion: Option<String>,
    /// The style in which `inverse` renders a contact, in place of the scene's own.
    pub render: Option<String>,
    /// Changes to the scene, or with `bench.` before the key to the bench, as `--set` takes them.
    #[serde(default)]
    pub set: Vec<String>,
    /// The thing that the experimenter lays under the finger, where no scene is played.
    pub present: Option<String>,
}

/// A question to the participant. Answers are chosen, not written: nothing personal is kept.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct Question {
    /// The question in one word: the name of a column.
    pub name: String,
    /// The question.
    pub text: String,
    /// Possible answers.
    pub choices: Vec<String>,
    /// True for a question after the trials; before them if left out.
    #[serde(default)]
    pub after: bool,
}

/// A study. Its tasks come in the order of this list, whatever the file's.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct Protocol {
    /// Name, in lower case with hyphens.
    pub name: String,
    /// The finding that the study is after, in a sentence.
    pub description: String,
    /// The values that are neither published nor measured; results flag it.
    pub assumed: Option<String>,
    /// The text that a participant agrees to before anything else.
    pub consent: Option<String>,
    /// The text that a participant reads before the first trial.
    pub instructions: Option<String>,
    /// Order in which conditions or wires come.
    #[serde(default = "blocks")]
    pub order: Order,
    /// Trials of each task that do not count, before those that do.
    #[serde(default)]
    pub practice: u32,
    /// Trials after which there is a break; left out: none.
    pub break_after: Option<u32>,
    /// Least length of a break, seconds.
    #[serde(default = "minute")]
    pub break_s: f64,
    /// Least time between two stimuli, seconds.
    #[serde(default = "second")]
    pub pause_s: f64,
    /// Time for which a wire is driven where a task names wires, seconds.
    #[serde(default = "burst")]
    pub stimulus_s: f64,
    /// Questions before and after the trials.
    #[serde(default)]
    pub questions: Vec<Question>,
    /// Conditions that tasks refer to by name.
    #[serde(default)]
    pub conditions: Vec<Condition>,
    /// The absolute threshold of each wire.
    pub absolute_threshold: Option<ThresholdTask>,
    /// The least difference that is felt.
    pub difference: Option<DifferenceTask>,
    /// Wires that shall feel alike.
    pub matching: Option<MatchTask>,
    /// The place at which a wire was felt.
    pub localisation: Option<LocateTask>,
    /// The path that was felt.
    pub drawing: Option<DrawTask>,
    /// Ratings from 1 to 6.
    pub rating: Option<RatingTask>,
    /// The choice between two conditions.
    pub choice: Option<ChoiceTask>,
}

const fn blocks() -> Order {
    Order::Blocks
}

const fn minute() -> f64 {
    60.0
}

const fn second() -> f64 {
    1.0
}

const fn burst() -> f64 {
    0.6
}

impl Condition {
    /// Changes that the condition makes to its scene and the bench.
    ///
    /// # Errors
    /// An entry of `set` that is not `KEY=VALUE`.
    pub fn overrides(&self) -> Result<Overrides, FileError> {
        let by = format!("condition `{}`", self.name);
        let mut overrides = Overrides::default();
        if let Some(model) = &self.illusion {
            overrides.scene(&by, "illusion.model", model);
        }
        if let Some(style) = &self.render {
            overrides.scene(&by, "illusion.render", style);
        }
        for text in &self.set {
            overrides.set(&by, text)?;
        }
        Ok(overrides)
    }

    fn check(&self, source: &Source, at: &str) -> Result<(), FileError> {
        check_text(source, &format!("{at}.name"), &self.name)?;
        match (&self.scene, &self.present) {
            (Some(_), None) => {}
            (None, Some(present)) => {
                check_text(source, &format!("{at}.present"), present)?;
                if self.illusion.is_some() || self.render.is_some() || !self.set.is_empty() {
                    return Err(source.bad(at, "no change where nothing is played"));
                }
            }
            _ => return Err(source.bad(at, "either `scene` or `present`")),
        }
        self.overrides()
            .map(drop)
            .map_err(|_| source.bad(&format!("{at}.set"), "KEY=VALUE"))
    }
}

/// Checks a name that none before it may have.
fn check_new<'n>(
    source: &Source,
    at: &str,
    name: &'n String,
    mut before: impl Iterator<Item = &'n String>,
) -> Result<(), FileError> {
    match before.any(|other| other == name) {
        true => Err(source.bad(&format!("{at}.name"), "each name once")),
        false => Ok(()),
    }
}

impl Question {
    fn check(&self, source: &Source, at: &str) -> Result<(), FileError> {
        check_word(source, &format!("{at}.name"), &self.name)?;
        check_text(source, &format!("{at}.text"), &self.text)?;
        if self.choices.len() < 2 {
            let key = format!("{at}.choices");
            return Err(source.bad(
                &key,
                "two choices at least: answers are chosen, not written",
            ));
        }
        for (index, choice) in self.choices.iter().enumerate() {
            check_text(source, &format!("{at}.choices[{index}]"), choice)?;
        }
        Ok(())
    }
}

impl Protocol {
    /// Reads and checks a protocol.
    ///
    /// # Errors
    /// Names the line and key of a value that is refused.
    pub fn read(source: &Source) -> Result<Self, FileError> {
        let file: Self = source.read()?;
        source.heading(&file.name, &file.description)?;
        file.check_session(source)?;
        file.check_tasks(source)?;
        file.check_names(source)?;
        let trials = file.trials();
        if trials == 0 {
            let expected = "a task: [absolute_threshold], [difference], [matching], [localisation], [drawing], [rating] or [choice]";
            return Err(source.bad_found("", expected, "none"));
        }
        if trials > MOST_TRIALS {
            let expected = format!("at most {MOST_TRIALS} trials in a session");
            return Err(source.bad_found("", expected, format!("{trials} trials")));
        }
        Ok(file)
    }

    /// A condition by its name.
    #[must_use]
    pub fn condition(&self, name: &str) -> Option<&Condition> {
        self.conditions.iter().find(|c| c.name == name)
    }

    /// Trials of a participant that count, and practice.
    #[must_use]
    pub fn trials(&self) -> u64 {
        let tasks = self.tasks().into_iter();
        let trials = tasks.map(|(_, things, each)| things as u64 * u64::from(each));
        trials.map(|trials| trials + u64::from(self.practice)).sum()
    }

    /// The tasks in their order, each with the number of its wires, conditions or pairs, and the repeats of each.
    #[must_use]
    pub fn tasks(&self) -> Vec<(TaskKind, usize, u32)> {
        use TaskKind as K;
        let absolute = self.absolute_threshold.as_ref();
        let (difference, matching) = (self.difference.as_ref(), self.matching.as_ref());
        let (places, drawing) = (self.localisation.as_ref(), self.drawing.as_ref());
        let (rating, choice) = (self.rating.as_ref(), self.choice.as_ref());
        let all = [
            absolute.map(|t| (K::AbsoluteThreshold, t.wires.len(), t.trials)),
            difference.map(|t| (K::Difference, t.wires.len(), t.trials)),
            matching.map(|t| (K::Matching, t.wires.len(), t.trials)),
            places.map(|t| (K::Localisation, t.wires.len(), t.repeats)),
            drawing.map(|t| (K::Drawing, t.conditions.len(), t.repeats)),
            rating.map(|t| (K::Rating, t.conditions.len(), t.repeats)),
            choice.map(|t| (K::Choice, t.pairs.len(), t.repeats)),
        ];
        all.into_iter().flatten().collect()
    }

    /// The wires of a task in the file's order; none of a task that names conditions, or that is not there.
    #[must_use]
    pub fn wires(&self, task: TaskKind) -> &[u16] {
        let wires = match task {
            TaskKind::AbsoluteThreshold => self.absolute_threshold.as_ref().map(|t| &t.wires),
            TaskKind::Difference => self.difference.as_ref().map(|t| &t.wires),
            TaskKind::Matching => self.matching.as_ref().map(|t| &t.wires),
            TaskKind::Localisation => self.localisation.as_ref().map(|t| &t.wires),
            TaskKind::Drawing | TaskKind::Rating | TaskKind::Choice => None,
        };
        wires.map_or(&[], |wires| wires)
    }

    fn check_session(&self, source: &Source) -> Result<(), FileError> {
        for (key, text) in [
            ("consent", &self.consent),
            ("instructions", &self.instructions),
        ] {
            if let Some(text) = text {
                check_text(source, key, text)?;
            }
        }
        bounds!(source, "", self;
            practice: 0..=100;
            break_after: 1..=10_000;
            break_s: 0.0..=3600.0, "s";
            pause_s: 0.1..=600.0, "s";
            stimulus_s: 0.1..=10.0, "s")?;
        for (index, question) in self.questions.iter().enumerate() {
            let at = format!("questions[{index}]");
            question.check(source, &at)?;
            let before = self.questions[..index].iter();
            check_new(source, &at, &question.name, before.map(|q| &q.name))?;
        }
        for (index, condition) in self.conditions.iter().enumerate() {
            let at = format!("conditions[{index}]");
            condition.check(source, &at)?;
            let before = self.conditions[..index].iter();
            check_new(source, &at, &condition.name, before.map(|c| &c.name))?;
        }
        Ok(())
    }

    fn check_tasks(&self, source: &Source) -> Result<(), FileError> {
        let check = |found: Option<Result<(), FileError>>| found.unwrap_or(Ok(()));
        check(self.absolute_threshold.as_ref().map(|t| t.check(source)))?;
        check(self.difference.as_ref().map(|t| t.check(source)))?;
        check(self.matching.as_ref().map(|t| t.check(source)))?;
        check(self.localisation.as_ref().map(|t| t.check(source)))?;
        check(self.drawing.as_ref().map(|t| t.check(source)))?;
        check(self.rating.as_ref().map(|t| t.check(source)))?;
        check(self.choice.as_ref().map(|t| t.check(source)))
    }

    /// Checks that every condition that a task names exists and suits the task.
    fn check_names(&self, source: &Source) -> Result<(), FileError> {
        let listed = |task: &str, names: &[String], played: bool| {
            if names.is_empty() {
                let key = format!("{task}.conditions");
                return Err(source.bad(&key, "one condition at least"));
            }
            names.iter().enumerate().try_for_each(|(index, name)| {
                let key = format!("{task}.conditions[{index}]");
                if names[..index].contains(name) {
                    return Err(source.bad(&key, "each condition once"));
                }
                self.known(source, &key, name, played)
            })
        };
        if let Some(task) = &self.drawing {
            listed("drawing", &task.conditions, true)?;
        }
        if let Some(task) = &self.rating {
            listed("rating", &task.conditions, false)?;
        }
        let pairs = self.choice.iter().flat_map(|task| &task.pairs).enumerate();
        for (index, pair) in pairs {
            for (side, name) in pair.iter().enumerate() {
                self.known(
                    source,
                    &format!("choice.pairs[{index}][{side}]"),
                    name,
                    false,
                )?;
            }
        }
        Ok(())
    }

    fn known(&self, source: &Source, key: &str, name: &str, played: bool) -> Result<(), FileError> {
        match self.condition(name) {
            Some(condition) if played && condition.scene.is_none() => {
                let expected = "a condition with a scene: its path is compared with the drawing";
                Err(source.bad(key, expected))
            }
            Some(_) => Ok(()),
            None => {
                let names = self.conditions.iter().map(|c| c.name.as_str());
                let found = format!("\"{name}\"{}", did_you_mean(name, names));
                Err(source.bad_found(key, "the name of one of [[conditions]]", found))
            }
        }
    }
}

#[cfg(test)]
mod tests;
