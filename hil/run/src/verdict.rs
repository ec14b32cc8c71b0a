//! The verdict on a run: a limit that was passed, a failure or stop, missing data, contacts that were not felt; and the
//! reason where nothing was driven.

use palpate_core::contact::Scope;
use palpate_files::{Overload, Scene, Setup, SkinModule};
use palpate_records::model;
use palpate_records::trace::{Event, Trace, event};
use palpate_records::verdict::{Conclusion, Verdict};

use crate::finder::not_at_rest;
use crate::summary::Summary;
use crate::summary_felt::AskedLevel;
use crate::{Failure, Outcome};

/// Modules and boards named one by one.
const NAMED: usize = 3;

/// Shortfall below which a level counts as reached, dB: the arithmetic is no nearer.
const NEAR_DB: f64 = 0.5;

/// Beginning of the note of a run that a person ended; a signal or the person follows.
pub(crate) const STOPPED_BY: &str = "stopped by ";

impl Outcome {
    /// Adds the verdict. `replayed` tells whether a recording drove the run, not the scene's touches.
    #[must_use]
    pub fn concluded(mut self, setup: &Setup, replayed: bool) -> Self {
        let scene = &setup.scene.value;
        self.summary.pitch_mm = pitch_mm(setup);
        let summary = &self.summary;
        let mut conclusion = Conclusion::default();
        conclusion.add_margins(&summary.margins);
        beyond(summary, &self.trace, &mut conclusion);
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
            unheard(summary, scene, replayed, &mut conclusion);
        }
        let taxels = &summary.taxels;
        for text in not_at_rest(taxels.rows_not_at_rest, taxels.taken_touched) {
            conclusion.add(Verdict::Ok, text);
        }
        if summary.frames_not_recorded > 0 {
            let lost = summary.frames_not_recorded;
            let text = format!("{lost} frames not recorded, the disk was too slow");
            conclusion.add(Verdict::Incomplete, text);
        }
        if let Some(banner) = self.trace.header.source.banner() {
            conclusion.add(Verdict::Ok, banner);
        }
        unfelt(summary, &mut conclusion);
        if summary.stimuli == 0 && summary.onsets.meant == 0 && summary.onsets.off_pad == 0 {
            let why = undriven(summary, scene, replayed);
            conclusion.add(Verdict::Ok, format!("no stimulus: {why}"));
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

/// Words for a level that the limits do not bear for a session, with the one that they do.
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

/// Taxels of which nothing came, although something did of their board. A remark where the scene has boards overwrite what
/// waits: high identifiers starve then, and the scene is about that.
fn unheard(summary: &Summary, scene: &Scene, replayed: bool, conclusion: &mut Conclusion) {
    let taxels = &summary.taxels;
    let silent = |module: &usize| {
        let board = summary.boards.get(*module);
        board.is_none_or(|board| board.readings == 0)
    };
    let ill = taxels.ill.iter();
    let never = ill.filter(|t| t.condition == "never-seen" && !silent(&t.module));
    let count = never.count();
    if count > 0 {
        let all: usize = taxels.refresh_each_hz.iter().map(Vec::len).sum();
        let foreign = match taxels.foreign {
            0 => "no frame was foreign".to_owned(),
            n => format!("{n} frames had identifiers that the layout does not know"),
        };
        let text = format!("{count} of {all} taxels never spoke, and {foreign}");
        let scripted = scene.boards.overload == Some(Overload::Overwrite) && !replayed;
        let verdict = match scripted {
            true => Verdict::Ok,
            false => Verdict::Incomplete,
        };
        conclusion.add(verdict, text);
    }
}

/// Temperatures beyond what the model knows, and since when.
fn beyond(summary: &Summary, trace: &Trace, conclusion: &mut Conclusion) {
    let passed = [
        ("a wire", summary.hottest_wire_c, model::WIRE_C),
        ("skin", summary.hottest_skin_c, model::TISSUE_C),
    ];
    let passed = passed.into_iter().filter_map(|(what, hottest, most)| {
        let beyond = hottest.filter(|c| model::known(*c, most).is_none());
        beyond.map(|_| format!("{what} passed {most:.0} C"))
    });
    let passed: Vec<String> = passed.collect();
    if trace.ledger.tight {
        let most = model::TIGHTEST * 100.0;
        let text = format!("a wire's bow passed {most:.0} % of its sag: mount.sag_um is too small");
        conclusion.add(Verdict::BeyondTheModel, text);
    }
    if passed.is_empty() {
        return;
    }
    let is_beyond = |event: &&Event| match event {
        Event::Wire(now) => f64::from(now.milli_c) * 1e-3 > model::WIRE_C,
        Event::Skin(now) => f64::from(now.milli_c) * 1e-3 > model::TISSUE_C,
        _ => false,
    };
    let first = trace.events.iter().find(is_beyond);
    let since = first.map_or_else(String::new, |event| {
        format!(" by {:.1} s", event.t_ns() as f64 * 1e-9)
    });
    let text = format!("{}{since}", passed.join(", "));
    conclusion.add(Verdict::BeyondTheModel, text);
}

/// Adds the shares of onsets beyond the display and of those not felt, for each of several displays by its name.
fn unfelt(summary: &Summary, conclusion: &mut Conclusion) {
    let displays = summary.displays.iter();
    let mut each: Vec<_> = displays
        .map(|d| {
            (
                format!("{}: ", d.name),
                &d.onsets,
                &d.felt.person,
                d.limiter_events,
            )
        })
        .collect();
    if each.is_empty() {
        let events = summary.limiter_events;
        each.push((String::new(), &summary.onsets, &summary.felt.person, events));
    }
    for (name, onsets, person, limited) in each {
        if onsets.mostly_off() {
            let (off, touched) = (onsets.off_pad, onsets.touched);
            conclusion.add(
                Verdict::OffThePad,
                format!(
                    "{name}{off} of {touched} touched onsets lie beyond what the display shows"
                ),
            );
        }
        let (meant, felt) = (onsets.meant, onsets.felt.unwrap_or(0));
        if onsets.mostly_unfelt() {
            let why = match (onsets.unfound == meant, felt, limited) {
                (true, ..) => "no reading of the touch rose above the contact threshold".to_owned(),
                (false, 0, 1..) if summary.stimuli == 0 => {
                    "the guard refused every stimulus".to_owned()
                }
                _ => format!("person `{person}` feels {felt} of {meant} onsets"),
            };
            conclusion.add(Verdict::NotFelt, format!("{name}{why}"));
        }
    }
}

/// Distance between neighbouring taxels on the modules that drive.
fn pitch_mm(setup: &Setup) -> Option<f64> {
    let scene = &setup.scene.value;
    let fingers = setup.fingers.iter();
    let of_fingers = fingers.flat_map(|f| &f.modules[..if f.merged { f.modules.len() } else { 1 }]);
    let mut driving: Vec<usize> = of_fingers.copied().collect();
    if driving.is_empty() {
        driving = match scene.compression.scope {
            Scope::Skin => (0..setup.sensor.value.modules.len()).collect(),
            Scope::Module => vec![scene.drives],
        };
    }
    let modules = driving
        .into_iter()
        .filter_map(|m| setup.sensor.value.modules.get(m));
    modules.filter_map(SkinModule::pitch_mm).reduce(f64::min)
}

/// Reason for which no wire was driven where nothing was meant to be felt.
fn undriven(summary: &Summary, scene: &Scene, replayed: bool) -> &'static str {
    if summary.frames == 0 {
        return "the run ended before there was a reference to hold readings against";
    }
    let touches_nothing = scene.touches.is_empty() && scene.strokes.is_empty();
    match (summary.contacts, replayed) {
        (0, true) => "no reading of the recording rose above the contact threshold",
        (0, false) if touches_nothing => "the scene touches nothing",
        (0, false) => "nothing touches the skin that drives the display",
        _ => "no contact was on the display at an onset",
    }
}

#[cfg(test)]
#[path = "verdict_tests.rs"]
mod tests;
