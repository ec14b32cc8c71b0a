//! The dose of a whole session, before a person is connected: every trial at its strongest, at the shortest pace.

use std::fmt::Write as _;
use std::io::{self, Write};

use palpate_core::guard::Guard;
use palpate_core::units::{Duration, Instant};
use palpate_run::Failure;
use palpate_study::{Known, Session, Stimulus, Trial};

use super::rehearsal::Rehearsals;
use super::stimuli::Stimuli;

/// Dose of a session at its strongest.
#[derive(Debug, Clone)]
pub struct Dose {
    /// The larger share of both doses that a session may have: Omega and CEM43.
    pub share: f64,
    /// Length of the session at the shortest pace, s.
    pub seconds: f64,
    /// Trials of each task, and the share that they add.
    pub tasks: Vec<(&'static str, usize, f64)>,
    /// Path of each condition.
    pub known: Known,
    /// Rehearsal of each stimulus.
    pub rehearsals: Rehearsals,
}

/// Computes the dose of what is left of a session. Each stimulus is played once on an emulated bench, from rest; then a guard
/// books all of them in the session's order, one after the other with the protocol's pause between.
///
/// # Errors
/// [`Failure`] of a bench that cannot play a stimulus.
pub fn planned(stimuli: &Stimuli, session: &Session) -> Result<Dose, Failure> {
    let protocol = &stimuli.protocol().value;
    let pause = Duration::from_micros((protocol.pause_s * 1e6) as u64);
    let mut known = Known {
        wires_mm: stimuli.wires_mm().to_vec(),
        ..Known::default()
    };
    let mut rehearsals = Rehearsals::default();
    let (mut together, mut until) = (stimuli.guard()?, Instant::ZERO);
    let mut tasks: Vec<(&'static str, usize, f64)> = Vec::new();
    let mut before = share(&together, until);
    let trials = session.strongest();
    let last_of = |index: usize, trial: &Trial| {
        trials
            .get(index + 1)
            .is_none_or(|next| next.task != trial.task)
    };
    for (index, trial) in trials.iter().enumerate() {
        for stimulus in &trial.intervals {
            let rehearsed = rehearsals.rehearsal(stimuli, stimulus)?;
            if let Stimulus::Condition(name) = stimulus {
                known.paths.insert(name.clone(), rehearsed.path.clone());
            }
            known.feel(stimulus, &rehearsed.sensed);
            let began = until + pause;
            let over = together.repeat(began, &rehearsed.bursts);
            until = (began + rehearsed.length).max(over);
        }
        match tasks
            .last_mut()
            .filter(|(task, ..)| *task == trial.task.name())
        {
            Some(task) => task.1 += 1,
            None => tasks.push((trial.task.name(), 1, 0.0)),
        }
        if last_of(index, trial) {
            let after = share(&together, until);
            if let Some(task) = tasks.last_mut() {
                task.2 = after - before;
            }
            before = after;
        }
    }
    Ok(Dose {
        share: before,
        seconds: until.since(Instant::ZERO).as_secs_f64(),
        tasks,
        known,
        rehearsals,
    })
}

/// The larger share of both doses at a time of the session.
fn share(guard: &Guard, at: Instant) -> f64 {
    let used = guard.used(at);
    used.omega.max(used.cem43)
}

impl Dose {
    /// Prints the dose, with the arithmetic.
    ///
    /// # Errors
    /// The writer's error.
    pub fn write(&self, out: &mut dyn Write) -> io::Result<()> {
        for (task, trials, share) in &self.tasks {
            let each = 100.0 * share / (*trials).max(1) as f64;
            writeln!(
                out,
                "  {task:<20}{trials:>5} trials at {each:.4} % = {:.2} %",
                100.0 * share
            )?;
        }
        writeln!(
            out,
            "  {:<20}{:.2} % of the dose that a session may have, in {:.0} min at its shortest",
            "session",
            100.0 * self.share,
            self.seconds / 60.0
        )
    }

    /// Refuses a session whose dose is more than a person may have.
    ///
    /// # Errors
    /// [`Failure::Input`] with the arithmetic.
    pub fn check(&self) -> Result<(), Failure> {
        if self.share < 1.0 {
            return Ok(());
        }
        let mut sum = String::new();
        for (task, trials, share) in &self.tasks {
            let each = 100.0 * share / (*trials).max(1) as f64;
            // Writing to a text does not fail.
            let _ = write!(
                sum,
                "{}{trials} trials of {task} at {each:.3} % = {:.0} %",
                if sum.is_empty() { "" } else { ", " },
                100.0 * share
            );
        }
        let fits = (1.0 / self.share).min(1.0);
        Err(Failure::Input(format!(
            "the session's dose: expected less than 100 % of what a session may have (Omega 0.01, CEM43 2 min), found {:.0} % in {:.0} min: {sum}. {:.0} % of the trials, or sessions on several days, fit",
            100.0 * self.share,
            self.seconds / 60.0,
            100.0 * fits
        )))
    }
}
