//! The hot pass before a run: wires that are cold are heated once through their transformation, one after the other.
//!
//! A pass is a run of its own, before the scene's t = 0, by the way of every run: the guard admits each pulse, hardware has
//! its guardian, and heat and dose are booked. The run that follows goes on from its heat, with wires that are assumed to be
//! passed: no bench measures that.

mod again;
mod heated;
mod plan;
mod report;

pub(crate) use again::Again;
pub use heated::lasting;
pub use report::{PassBurst, PassEnd, PassReport};

use std::borrow::Cow;

use palpate_core::guard::Booked;
use palpate_files::{Pass, Setup, WireState};
use palpate_records::verdict::Verdict;

use crate::{Failure, Outcome, stopped_by};

/// Tells whether a run on this setup begins with a hot pass: its wires are cold, and its bench does not forbid it.
#[must_use]
pub fn is_due(setup: &Setup) -> bool {
    setup.pass == Pass::Before
        && setup.bench.value.haptics.is_none()
        && setup.bench.value.drive.hot_pass
        && setup.wire.value.state == WireState::Cold
}

/// Tells whether a pass would last: the wires can be at rest once they are passed, and stay so.
#[must_use]
pub fn lasts(setup: &Setup) -> bool {
    plan::lasts(setup).is_ok()
}

/// State in which the wires of a run begin, for people and programs.
#[must_use]
pub const fn state_of(setup: &Setup) -> &'static str {
    match setup.wire.value.state {
        WireState::Passed => "assumed passed",
        WireState::Cold => "cold",
    }
}

/// Announces a run that is a pass to who wears the display.
#[must_use]
pub fn announced(own: &Setup) -> String {
    format!(
        "hot pass: for {:.1} s each wire is heated in turn, one each second or slower; each is felt as a tap",
        own.scene.value.length_s
    )
}

/// Passes the wires of a setup that need it. `play` plays a scene on the setup's bench. Returns the setup of the run that
/// follows, and what the pass came to.
///
/// # Errors
/// The failures of `play`; [`Failure::Check`] for a pass that passed a limit, [`Failure::Stopped`] for one that a person ended.
pub fn before(
    setup: &Setup,
    play: impl FnOnce(&Setup) -> Result<Outcome, Failure>,
) -> Result<(Cow<'_, Setup>, Option<PassReport>), Failure> {
    if !is_due(setup) {
        return Ok((Cow::Borrowed(setup), None));
    }
    let mut after = setup.clone();
    let planned = match plan::plan(setup)? {
        Ok(planned) => planned,
        Err(why) => {
            after.told = Some(format!("none: {why}"));
            return Ok((Cow::Owned(after), None));
        }
    };
    let outcome = play(&planned.setup)?;
    if let Some(failure) = outcome.failure {
        return Err(failure);
    }
    if let Some(by) = stopped_by(&outcome.trace) {
        let text = format!("the hot pass was stopped by {by}; outputs are off");
        return Err(Failure::Stopped(text));
    }
    let conclusion = &outcome.summary.conclusion;
    if conclusion.verdict == Verdict::LimitExceeded {
        return Err(Failure::Check(format!("hot pass: {}", conclusion.line())));
    }
    let report = PassReport::new(&planned, &outcome);
    remember(&mut after, &outcome);
    if report.has_passed {
        set_passed(&mut after);
    }
    after.told = Some(report.line());
    Ok((Cow::Owned(after), Some(report)))
}

/// Bursts of the pass that a run on this setup begins with: wire, and what the guard books at most, from the pass's beginning
/// on. Empty where no pass is due, or none would last.
///
/// # Errors
/// [`Failure::Input`] for a setup that fits no loop.
pub fn bookings(setup: &Setup) -> Result<Vec<(u16, Booked)>, Failure> {
    let planned = match is_due(setup) {
        true => plan::plan(setup)?.ok(),
        false => None,
    };
    Ok(planned.map_or_else(Vec::new, |planned| planned.bookings()))
}

/// Adds to a run's outcome what a pass before it came to: the report, or the reason why there was none.
pub fn tell(outcome: &mut Outcome, setup: &Setup, report: Option<PassReport>) {
    let why = setup.told.as_ref().filter(|_| report.is_none());
    outcome.summary.no_pass = why.cloned();
    outcome.summary.pass = report;
}

/// Lets the wires of a setup begin as after a pass.
pub fn set_passed(setup: &mut Setup) {
    setup.wire.value.state = WireState::Passed;
}

/// Lets the guards of the run that follows go on from the heat of a pass.
fn remember(setup: &mut Setup, outcome: &Outcome) {
    let memory = |outcome: &Outcome| outcome.pass.as_ref().map(|pass| pass.memory.clone());
    for (finger, display) in setup.fingers.iter_mut().zip(&outcome.displays) {
        finger.memory = memory(&display.outcome);
    }
    if setup.fingers.is_empty() {
        setup.memory = memory(outcome);
    }
}

#[cfg(test)]
mod tests;
