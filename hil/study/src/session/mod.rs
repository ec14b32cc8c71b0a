//! A participant's session: its steps, and the answers to them.
//!
//! The order follows from protocol, participant and seed alone; levels follow from the answers. So a session that is begun
//! again with the replies on record stands where it stood.

mod make;
mod order;
mod script;
mod trial;

use std::collections::BTreeMap;

use palpate_files::{Protocol, TaskKind};
use serde::{Deserialize, Serialize};

use crate::quest::Estimate;
use crate::threshold::Thresholding;

use script::{Line, script};
pub use trial::{Answer, AnswerError, Ask, Sample, Stimulus, Trial};

/// Reply of a participant, or the bench, to a step.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum Reply {
    /// Answer to the consent.
    Consent(bool),
    /// Instructions were read, or a break is over.
    Read,
    /// Answer to a question: the number of the choice, from zero.
    Chosen(usize),
    /// Answer to a trial.
    Answer(Answer),
    /// The trial came to nothing, for this reason; it is repeated.
    Void(String),
}

/// Step that a session waits for.
#[derive(Debug, Clone, PartialEq)]
pub enum Step {
    /// Agreement to the protocol's text.
    Consent,
    /// Word that the protocol's instructions were read.
    Instructions,
    /// One of the protocol's questions, by its number.
    Question(usize),
    /// Word that a break is over.
    Break,
    /// A trial, to be played and answered.
    Trial(Trial),
    /// The end of the session.
    Done,
    /// The end of a session whose participant did not agree.
    Declined,
}

/// A session of a participant.
#[derive(Debug, Clone)]
pub struct Session {
    protocol: Protocol,
    script: Vec<Line>,
    at: usize,
    /// Number of earlier beginnings of the open trial.
    attempt: u32,
    declined: bool,
    /// Methods by task whose levels follow from answers, one per wire.
    methods: BTreeMap<TaskKind, Vec<Thresholding>>,
    step: Step,
}

/// Difference of levels between an amplitude of `level_db` and one larger by the part `fraction_db` of it, dB.
pub(crate) fn raised(level_db: f64, fraction_db: f64) -> f64 {
    level_db + 20.0 * libm::log10(1.0 + libm::pow(10.0, fraction_db / 20.0))
}

impl Session {
    /// A participant's session from its beginning. Participants count from 1.
    #[must_use]
    pub fn new(protocol: Protocol, participant: u32, seed: u64) -> Self {
        let absolute = protocol.absolute_threshold.as_ref();
        let absolute = absolute.map(|t| Thresholding::absolute(t.method, t.trials));
        let difference = protocol.difference.as_ref();
        let difference =
            difference.map(|t| Thresholding::difference(t.method, t.trials, t.level_db));
        let matching = protocol.matching.as_ref();
        let matching = matching.map(|t| Thresholding::matching(t.trials));
        let methods = [
            (TaskKind::AbsoluteThreshold, absolute),
            (TaskKind::Difference, difference),
            (TaskKind::Matching, matching),
        ];
        let methods = methods.into_iter().filter_map(|(task, method)| {
            let wires = protocol.wires(task).len();
            Some((task, vec![method?; wires]))
        });
        let mut session = Self {
            script: script(&protocol, participant, seed),
            at: 0,
            attempt: 0,
            declined: false,
            methods: methods.collect(),
            step: Step::Done,
            protocol,
        };
        session.step = session.found();
        session
    }

    /// Protocol of the session.
    #[must_use]
    pub const fn protocol(&self) -> &Protocol {
        &self.protocol
    }

    /// Step that the session waits for.
    #[must_use]
    pub const fn step(&self) -> &Step {
        &self.step
    }

    /// Trials that are over and all trials, with practice.
    #[must_use]
    pub fn progress(&self) -> (usize, usize) {
        let trials = |lines: &[Line]| {
            let trials = lines.iter().filter(|line| matches!(line, Line::Trial(_)));
            trials.count()
        };
        (trials(&self.script[..self.at]), trials(&self.script))
    }

    /// Every trial to come, each at its strongest where the level follows from answers.
    #[must_use]
    pub fn strongest(&self) -> Vec<Trial> {
        let cues = (self.at..self.script.len()).filter_map(|at| match self.script[at] {
            Line::Trial(cue) => Some(self.trial(cue, at, true)),
            _ => None,
        });
        cues.collect()
    }

    /// Estimates of a task from the answers so far, one per wire, dB of full drive: the least level that is felt, or the level that
    /// feels as strong as the reference. Of `difference` it is the least part of the amplitude that is felt, dB.
    #[must_use]
    pub fn estimates(&self, task: TaskKind) -> Vec<(u16, Estimate)> {
        let found = self.methods.get(&task).into_iter().flatten();
        let wires = self.protocol.wires(task).iter().copied();
        wires.zip(found.map(Thresholding::threshold)).collect()
    }

    /// Checks that this is a reply to the present step.
    ///
    /// # Errors
    /// The expected reply, in words.
    pub fn check(&self, reply: &Reply) -> Result<(), AnswerError> {
        match (&self.step, reply) {
            (Step::Consent, Reply::Consent(_))
            | (Step::Instructions | Step::Break, Reply::Read)
            | (Step::Trial(_), Reply::Void(_)) => Ok(()),
            (Step::Question(number), Reply::Chosen(choice)) => {
                let choices = self.protocol.questions[*number].choices.len();
                match *choice < choices {
                    true => Ok(()),
                    false => Err(AnswerError::Kind {
                        expected: format!("a choice below {choices}"),
                        found: choice.to_string(),
                    }),
                }
            }
            (Step::Trial(trial), Reply::Answer(answer)) => trial.ask.check(answer),
            (step, _) => Err(AnswerError::Step(wants(step))),
        }
    }

    /// Takes a reply in and goes on.
    ///
    /// # Errors
    /// As [`Self::check`]; nothing has changed then.
    pub fn take(&mut self, reply: &Reply) -> Result<(), AnswerError> {
        self.check(reply)?;
        match (&self.step, reply) {
            (_, Reply::Consent(agreed)) => self.declined = !agreed,
            (_, Reply::Void(_)) => {
                self.attempt += 1;
                self.step = self.found();
                return Ok(());
            }
            (Step::Trial(trial), Reply::Answer(answer)) => {
                let trial = trial.clone();
                self.learn(&trial, answer);
            }
            _ => {}
        }
        if !self.declined {
            self.at += 1;
        }
        self.attempt = 0;
        self.step = self.found();
        Ok(())
    }

    /// Tells a method of thresholds the answer at its level.
    fn learn(&mut self, trial: &Trial, answer: &Answer) {
        let (Some(level_db), Answer::Interval(chosen), false) =
            (trial.level_db, answer, trial.practice)
        else {
            return;
        };
        let Line::Trial(cue) = self.script[self.at] else {
            return;
        };
        let yes = trial.right == Some(*chosen);
        if let Some(of_wires) = self.methods.get_mut(&trial.task) {
            of_wires[cue.thing].answer(level_db, yes);
        }
    }

    fn found(&self) -> Step {
        if self.declined {
            return Step::Declined;
        }
        match self.script.get(self.at) {
            None => Step::Done,
            Some(Line::Consent) => Step::Consent,
            Some(Line::Instructions) => Step::Instructions,
            Some(Line::Question(number)) => Step::Question(*number),
            Some(Line::Break) => Step::Break,
            Some(Line::Trial(cue)) => Step::Trial(self.trial(*cue, self.at, false)),
        }
    }
}

/// The expected reply to a step, in words.
const fn wants(step: &Step) -> &'static str {
    match step {
        Step::Consent => "whether the participant agrees",
        Step::Instructions => "that the instructions were read",
        Step::Question(_) => "a choice",
        Step::Break => "that the break is over",
        Step::Trial(_) => "an answer to the trial, or that it is void",
        Step::Done | Step::Declined => "nothing: the session is over",
    }
}

#[cfg(test)]
mod tests;
