//! The verdict on a run: a limit that was passed, what failed or stopped it, what never came; and why nothing was
//! driven, where nothing was.

use palpate_files::{Scene, Setup};
use palpate_records::trace::{Trace, event};
use palpate_records::verdict::{Conclusion, Verdict};

use crate::summary::{AskedLevel, Summary};
use crate::{Failure, Outcome};

/// Modules and boards named one by one.
const NAMED: usize = 3;

/// A level that lacks less than this is had, dB: the arithmetic is no nearer.
const NEAR_DB: f64 = 0.5;

/// What the note of a run begins with that a person ended; a signal or the person follows.
pub(crate) const STOPPED_BY: &str = "stopped by ";

impl Outcome {
    /// With its verdict. `replayed` is whether a recording drove the run, not the scene's touches.
    #[must_use]
    pub fn concluded(mut self, setup: &Setup, replayed: bool) -> Self {
        let scene = &setup.scene.value;
        let summary = &self.summary;
        let mut conclusion = Conclusion::default();
        conclusion.add_margins(&summary.margins);
        match &self.failure {
            Some(stop @ Failure::Guard(_)) => conclusion.add(Verdict::Stopped, stop.to_string()),
            Some(failure) => conclusion.add(Verdict::Failed, failure.to_string()),
            None => {}
        }
        if let Some(by) = stopped_by(&self.trace) {
            conclusion.add(Verdict::Stopped, format!("by {by}"));
        }
        if scene.faults.is_empty() {
            missing(summary, &mut conclusion);
        }
        if summary.frames_not_recorded > 0 {
            let lost = summary.frames_not_recorded;
            let text = format!("{lost} frames not recorded, the disk was too slow");
            conclusion.add(Verdict::Incomplete, text);
        }
        if let Some(banner) = self.trace.header.source.banner() {
            conclusion.add(Verdict::Ok, banner);
        }
        if summary.stimuli == 0 {
            conclusion.add(
                Verdict::Ok,
                format!("no stimulus: {}", undriven(summary, scene, replayed)),
            );
        }
        if let Some(missing) = summary.felt.missing_db {
            let file = setup.person.source.label();
            conclusion.add(Verdict::Ok, format!(
                "person `{}` feels nothing: one wire at the limits is {missing:.1} dB below the threshold ({file}: vibration.threshold_um)",
                summary.felt.person
            ));
        }
        if let Some(why) = summary.felt.asked.as_ref().and_then(unsustained) {
            conclusion.add(Verdict::Ok, why);
        }
        self.summary.conclusion = conclusion;
        self
    }
}

/// A level that the limits do not bear for a session, with the one that they do.
fn unsustained(asked: &AskedLevel) -> Option<String> {
    let AskedLevel {
        level_db,
        moving_db,
        resting_db,
        ..
    } = *asked;
    let least = moving_db.min(resting_db);
    (level_db - least > NEAR_DB).then(|| format!(
        "illusion.level_db = {level_db}: for ten minutes one wire bears {resting_db:+.1} dB at rest and {moving_db:+.1} dB of a contact that moves"
    ))
}

/// The signal or person that ended a run before its time, if one did.
pub fn stopped_by<'a>(trace: &'a Trace) -> Option<&'a str> {
    let words = |note: &'a event::Note| note.text.strip_prefix(STOPPED_BY);
    trace.each().filter_map(words).next_back()
}

/// Boards or modules of which nothing came.
fn missing(summary: &Summary, conclusion: &mut Conclusion) {
    let (silent, heard): (Vec<_>, Vec<_>) = summary.boards.iter().partition(|b| b.readings == 0);
    if silent.is_empty() {
        return;
    }
    let name = |b: &&crate::BoardReport| match (b.bus, b.board) {
        (Some(bus), Some(board)) => format!("board {board} on bus {bus}"),
        _ => format!("module `{}`", b.name),
    };
    let mut names: Vec<String> = silent.iter().take(NAMED).map(name).collect();
    if let Some(more) = silent.len().checked_sub(NAMED).filter(|n| *n > 0) {
        names.push(format!("{more} more"));
    }
    let were = if heard.len() == 1 { "was" } else { "were" };
    conclusion.add(
        Verdict::Incomplete,
        format!(
            "no reading of {}: the layout expects {}, {} {were} heard",
            names.join(", "),
            summary.boards.len(),
            heard.len()
        ),
    );
}

/// Why no wire was driven.
fn undriven(summary: &Summary, scene: &Scene, replayed: bool) -> &'static str {
    if summary.frames == 0 {
        return "the run ended before there was a reference to hold readings against";
    }
    if summary.contacts == 0 {
        return match (
            replayed,
            scene.touches.is_empty() && scene.strokes.is_empty(),
        ) {
            (true, _) => "no reading of the recording rose above the contact threshold",
            (false, true) => "the scene touches nothing",
            (false, false) => "the touch never meets the pad",
        };
    }
    if summary.limiter_events > 0 {
        "the guard refused every one"
    } else {
        "no contact lies on the part of the skin that is mapped to the display"
    }
}

#[cfg(test)]
#[path = "verdict_tests.rs"]
mod tests;
