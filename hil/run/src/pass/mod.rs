//! The hot pass before a run: wires that are cold are heated once through their transformation, one after the other.
//!
//! A pass is a run of its own, before the scene's t = 0, by the way of every run: the guard admits each pulse, hardware has
//! its guardian, and heat and dose are booked. The run that follows goes on from its heat, with wires that are assumed to be
//! passed: no bench measures that.

mod heated;
mod plan;
mod report;

pub use heated::PASSED;
pub use report::{PassBurst, PassEnd, PassReport};

use std::borrow::Cow;

use palpate_files::{Pass, Setup, WireState};
use palpate_records::verdict::Verdict;

use crate::{Failure, Outcome, stopped_by};

/// Note of a run whose wires are not passed.
const TIGHT: &str = "none: a passed wire would pull its bow tight at rest, so the wires stay cold; expected a deeper bow";

/// Tells whether a run on this setup begins with a hot pass: its wires say what they went through, and are cold.
#[must_use]
pub fn is_due(setup: &Setup) -> bool {
    let wire = &setup.wire.value;
    let is_cold = wire.state.unwrap_or(WireState::Cold) == WireState::Cold;
    setup.pass == Pass::Before && wire.sag_state.is_some() && is_cold
}

/// State in which the wires of a run begin, for people and programs; `None` for wires that say nothing of it.
#[must_use]
pub fn state_of(setup: &Setup) -> Option<&'static str> {
    let wire = &setup.wire.value;
    wire.sag_state.map(|_| match wire.state {
        Some(WireState::Passed) => "assumed passed",
        Some(WireState::Cold) | None => "cold",
    })
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
    let Some(planned) = plan::plan(setup)? else {
        after.told = Some(TIGHT.to_owned());
        return Ok((Cow::Owned(after), None));
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
    if !setup.bench.value.is_hardware() {
        remember(&mut after, &outcome);
    }
    if report.has_passed {
        set_passed(&mut after);
    }
    after.told = Some(report.line());
    Ok((Cow::Owned(after), Some(report)))
}

/// Lets the wires of a setup begin as after a pass.
pub fn set_passed(setup: &mut Setup) {
    setup.wire.value.state = Some(WireState::Passed);
}

/// Lets the guards of an emulated bench go on from the heat of a pass. Hardware has its ledger.
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
