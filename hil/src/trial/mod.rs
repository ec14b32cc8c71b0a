//! Scenes as trials on a bench: what is measured against what a scene expects, what a bench lacks, how healthy it
//! is afterwards, and what a test server reads of it.

mod capability;
mod golden;
mod health;
mod junit;
pub mod last;
mod measure;
mod page;
mod suite;
mod unclaimed;

use std::fmt;
use std::time::Duration;

use palpate_files::Setup;
use palpate_live::clock;
use palpate_live::host;
use palpate_live::views::Wanted;
use palpate_records::verdict::{Conclusion, Verdict};
use palpate_run::{Failure, Input, Keep, Outcome, stopped_by};

pub use capability::lacks;
pub use golden::{FOLDER as GOLDENS, Goldens, Held};
use health::{after_emulated, after_real};
pub use junit::junit;
pub use measure::{Bound, Measure, expects_anything, measures};
pub use page::page;
pub use suite::{Member, Suite};
pub use unclaimed::unclaimed;

/// End of a trial.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum TrialEnd {
    /// Everything was as expected at the first try.
    Passed,
    /// Expected end of a run whose verdict fails nothing: `NOT FELT` or `OFF THE PAD`.
    Noted(Conclusion),
    /// Everything was as expected, after the failed tries that are listed.
    Unstable(Vec<String>),
    /// An unexpected end, or a run that failed, with the verdict and its reasons.
    Failed(Conclusion),
    /// Failed, but known to: why it failed, and the reason in the quarantine file.
    Quarantined(Conclusion, String),
    /// A trial that was not run, with the thing that the scene wants and the bench lacks.
    Refused(String),
    /// A trial that was not run, and the reason.
    Skipped(String),
    /// A trial that was not run because its files are wrong, and the error.
    Broken(String),
}

impl TrialEnd {
    /// The word a list begins with: the verdict, or why there is none.
    pub const fn word(&self) -> &'static str {
        match self {
            Self::Unstable(_) => "UNSTABLE",
            Self::Quarantined(..) => "QUARANTINED",
            Self::Refused(_) => "REFUSED",
            Self::Skipped(_) => "SKIPPED",
            _ => self.verdict().word(),
        }
    }

    /// The word for programs.
    pub const fn key(&self) -> &'static str {
        match self {
            Self::Unstable(_) => "unstable",
            Self::Quarantined(..) => "quarantined",
            Self::Refused(_) => "refused",
            Self::Skipped(_) => "skipped",
            _ => self.verdict().key(),
        }
    }

    /// Verdict of the trial among others.
    pub const fn verdict(&self) -> Verdict {
        match self {
            Self::Failed(conclusion) | Self::Noted(conclusion) => conclusion.verdict,
            Self::Broken(_) => Verdict::Failed,
            _ => Verdict::Ok,
        }
    }

    /// Reasons of the end, a line each.
    pub fn why(&self) -> &[String] {
        match self {
            Self::Passed => &[],
            Self::Refused(why) | Self::Skipped(why) | Self::Broken(why) => {
                std::slice::from_ref(why)
            }
            Self::Unstable(before) => before,
            Self::Failed(of) | Self::Noted(of) | Self::Quarantined(of, _) => &of.why,
        }
    }

    /// Tells whether the scene was tried at all.
    pub const fn is_tried(&self) -> bool {
        !matches!(self, Self::Refused(_) | Self::Skipped(_))
    }
}

/// A trial that was decided.
#[derive(Clone, Debug, PartialEq)]
pub struct Trial {
    /// The scene.
    pub scene: String,
    /// End of the trial.
    pub end: TrialEnd,
    /// Measured values of the last try.
    pub measures: Vec<Measure>,
    /// Time that all tries took.
    pub took: Duration,
    /// A line beside the verdict: what the operator should know.
    pub remark: Option<String>,
    /// Goldens that held the trial.
    pub goldens: Held,
}

impl Trial {
    /// A trial that was run once.
    pub fn new(scene: &str, tried: Try, took: Duration) -> Self {
        Self {
            scene: scene.to_owned(),
            end: match (tried.wrong.verdict, tried.noted.verdict) {
                (Verdict::Ok, Verdict::Ok) => TrialEnd::Passed,
                (Verdict::Ok, _) => TrialEnd::Noted(tried.noted),
                _ => TrialEnd::Failed(tried.wrong),
            },
            measures: tried.measures,
            took,
            remark: None,
            goldens: Held::default(),
        }
    }

    /// A trial that was not run, by its end.
    pub fn untried(scene: &str, end: TrialEnd) -> Self {
        Self {
            scene: scene.to_owned(),
            end,
            measures: Vec::new(),
            took: Duration::ZERO,
            remark: None,
            goldens: Held::default(),
        }
    }

    /// A trial whose files are wrong.
    pub fn broken(scene: &str, why: String) -> Self {
        Self::untried(scene, TrialEnd::Broken(why))
    }
}

/// One try: what was measured, and what is wrong.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Try {
    /// Measured values.
    pub measures: Vec<Measure>,
    /// Verdict and reasons of a failure; [`Verdict::Ok`] where the try passed.
    pub wrong: Conclusion,
    /// The run's own verdict where it is none that fails; [`Verdict::Ok`] where there is nothing to note.
    pub noted: Conclusion,
    /// The reason for which no further trial can be run.
    pub halt: Option<Halt>,
}

/// Reasons for which the trials end before all were run.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Halt {
    /// A person ended them: the signal.
    Stopped(String),
    /// The bench is not well: what is wrong with it.
    Unwell(String),
}

impl fmt::Display for Halt {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Stopped(signal) => write!(out, "stopped by {signal}"),
            Self::Unwell(why) => write!(out, "the bench is not well: {why}"),
        }
    }
}

/// Runs a scene up to `1 + retries` times until it passes; a bench that is not well is not tried again. Returns the
/// trial, and why nothing more can be run, if so.
pub fn decide(
    scene: &str,
    retries: u32,
    mut attempt: impl FnMut() -> Try,
) -> (Trial, Option<Halt>) {
    let started = clock::now();
    let mut before = Vec::new();
    let mut left = retries;
    loop {
        let tried = attempt();
        let retry = left > 0 && tried.halt.is_none();
        if tried.wrong.verdict != Verdict::Ok && retry {
            left -= 1;
            before.push(tried.wrong.why.join("; "));
            continue;
        }
        let halt = tried.halt.clone();
        let mut trial = Trial::new(scene, tried, started.elapsed());
        let passed = matches!(trial.end, TrialEnd::Passed | TrialEnd::Noted(_));
        if passed && !before.is_empty() {
            trial.end = TrialEnd::Unstable(before);
        }
        return (trial, halt);
    }
}

/// Runs a scene once on its bench and looks at what it left behind; `also` holds the run against what else is known.
///
/// # Errors
/// [`Failure::Input`] for a scene or bench that cannot be run at all; what `also` says.
pub fn attempt(
    setup: &Setup,
    seed: u64,
    also: impl FnOnce(&Outcome, &mut Conclusion) -> Result<(), Failure>,
) -> Result<Try, Failure> {
    let is_real = setup.bench.value.is_hardware();
    let wanted = Wanted {
        quiet: true,
        ..Wanted::default()
    };
    match host::run(setup, &Input::Scene, seed, Keep::default(), wanted) {
        Ok(outcome) => {
            let mut tried = judge(setup, &outcome);
            also(&outcome, &mut tried.wrong)?;
            Ok(tried)
        }
        Err(bad @ (Failure::Input(_) | Failure::File(_))) => Err(bad),
        Err(failure) => Ok(Try {
            wrong: Conclusion {
                verdict: Verdict::Failed,
                why: vec![failure.to_string()],
            },
            halt: is_real.then(|| Halt::Unwell(failure.to_string())),
            ..Try::default()
        }),
    }
}

/// A finished run against its scene's expectations, and the bench it left behind.
pub fn judge(setup: &Setup, outcome: &Outcome) -> Try {
    let bench = &setup.bench.value;
    let is_real = bench.is_hardware();
    let health = if bench.unit_address().is_some() {
        // Its own stops are failures of the run; nothing of it hangs on this computer.
        Vec::new()
    } else if is_real {
        after_real(bench, outcome)
    } else {
        after_emulated(&setup.scene.value, outcome)
    };
    let measures = measures(setup, outcome);
    let mut wrong = Conclusion::default();
    for why in measures.iter().filter_map(Measure::wrong) {
        wrong.add(Verdict::Failed, why);
    }
    // What the run itself came to, but for the limits that a scene expects to be passed in an emulator.
    let found = &outcome.summary.conclusion;
    let over = found.verdict.is_harmful();
    let expected = setup.scene.value.expect.over_limit && over && !is_real;
    if !found.verdict.is_done() && !expected {
        let mut why = found.why.iter();
        why.next()
            .into_iter()
            .for_each(|first| wrong.add(found.verdict, first));
        why.for_each(|more| wrong.add(Verdict::Ok, more));
    } else if let Some(failure) = &outcome.failure {
        wrong.add(Verdict::Failed, failure.to_string());
    }
    let stopped = stopped_by(&outcome.trace).map(|signal| Halt::Stopped(signal.to_owned()));
    let unwell = (is_real && !health.is_empty()).then(|| Halt::Unwell(health.join("; ")));
    for why in health {
        wrong.add(Verdict::Failed, format!("bench: {why}"));
    }
    let is_noted = found.verdict.is_done() && found.verdict != Verdict::Ok;
    Try {
        measures,
        wrong,
        noted: match is_noted {
            true => found.clone(),
            false => Conclusion::default(),
        },
        halt: unwell.or(stopped),
    }
}

#[cfg(test)]
mod tests;
