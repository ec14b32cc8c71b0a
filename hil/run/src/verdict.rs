//! The verdict on a run: a limit that was passed, what failed or stopped it, what never came; and why nothing was
//! driven, where nothing was.

use palpate_files::Scene;
use palpate_records::trace::{Event, Trace};
use palpate_records::verdict::{Conclusion, Verdict};

use crate::summary::Summary;
use crate::{Failure, Outcome};

/// Modules and boards named one by one.
const NAMED: usize = 3;

/// What the note of a run begins with that a person ended; a signal or the person follows.
pub(crate) const STOPPED_BY: &str = "stopped by ";

impl Outcome {
    /// With its verdict. `replayed` is whether a recording drove the run, not the scene's touches.
    #[must_use]
    pub fn concluded(mut self, scene: &Scene, replayed: bool) -> Self {
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
        self.summary.conclusion = conclusion;
        self
    }
}

/// The signal or person that ended a run before its time, if one did.
pub fn stopped_by(trace: &Trace) -> Option<&str> {
    let mut notes = trace.events.iter().filter_map(|e| match e {
        Event::Note { text, .. } => text.strip_prefix(STOPPED_BY),
        _ => None,
    });
    notes.next_back()
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
