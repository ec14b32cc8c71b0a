//! Duties of both ends of a run in real time besides sensing and driving; the begin and the leave of sessions between
//! them.

use std::sync::Arc;

use palpate_buses::can::{Note, Tally};
use palpate_buses::guardian::Lost;
use palpate_buses::pacer::{RunClock, Watch};
use palpate_core::guard::Guard;
use palpate_core::projector::Projector;
use palpate_core::skin::CanSkin;
use palpate_core::units::Instant;
use palpate_records::readings::Readings;
use palpate_run::display_end::DisplayEnd;
use palpate_run::skin_end::{SkinEnd, Tap};
use palpate_run::unit::UnitReport;
use palpate_run::wires::EmulatedDisplay;
use palpate_run::{
    CanPlayer, EmulatedSkin, Failure, HeatReport, Policy, Recorder, Rows, Session, Truth,
};

use super::bench::Interfaces;
use super::heat::Heat;
use crate::clock;

/// The sensor end.
pub trait Sensed: SkinEnd {
    /// Tells boards to send: the outputs are ready.
    fn begin(&mut self) {}

    /// Next note about a bus.
    fn note(&mut self) -> Option<Note> {
        None
    }

    /// Tallies of all interfaces.
    fn tallies(&self) -> Vec<Tally> {
        Vec::new()
    }
}

/// The boards on a bench's interfaces.
pub type RealSkin = CanSkin<Tap<Interfaces>>;

impl Sensed for RealSkin {
    fn begin(&mut self) {
        // The session makes up for an error here: it tells silent boards again.
        let _ = self.start_all();
    }

    fn note(&mut self) -> Option<Note> {
        self.bus_mut().inner.note()
    }

    fn tallies(&self) -> Vec<Tally> {
        self.bus().inner.tallies()
    }
}

impl Sensed for EmulatedSkin {}

impl Sensed for Rows<'_> {}

impl Sensed for CanSkin<Tap<CanPlayer<'_>>> {}

impl<S: Sensed + ?Sized> Sensed for Box<S> {
    fn begin(&mut self) {
        (**self).begin();
    }

    fn note(&mut self) -> Option<Note> {
        (**self).note()
    }

    fn tallies(&self) -> Vec<Tally> {
        (**self).tallies()
    }
}

/// The display end, and what watches over it.
pub trait Watched: DisplayEnd {
    /// Boards that were found driving before the run, a line each.
    fn found(&self) -> &str {
        ""
    }

    /// Meets the hardware again, last of all before the outputs start: it may have fallen silent while the run was
    /// prepared.
    fn meet(&mut self) -> Result<(), Failure> {
        Ok(())
    }

    /// Returns when no other display's transfer is on its bus.
    fn wait(&self) {}

    /// Checks before a turn that the run may go on.
    fn beat(&mut self, now: Instant) -> Result<(), Failure>;

    /// Accounts of heat, and this fingertip's number in them; `None` for an emulated display.
    fn ledger(&self) -> Option<(&Arc<Heat>, usize)> {
        None
    }

    /// Tells whether a guardian switches off outputs that this program leaves on.
    fn is_guarded(&self) -> bool {
        true
    }

    /// Gives up the run before its begin, for this cause.
    fn abandon(&mut self, cause: &str);

    /// Takes the end of the loop, with outputs `off` or the reason why they may be on; `failed` if something else ended
    /// it. Returns whether they are known to be off.
    fn part(&mut self, off: Result<(), String>, failed: bool) -> Result<(), String>;

    /// Report of the driver unit; `None` where the end is none.
    fn unit(&self) -> Option<UnitReport> {
        None
    }

    /// Report of the Peltier module on that unit, where the bench has one.
    fn heat(&self) -> Option<HeatReport> {
        None
    }
}

/// Failure of a run whose guardian is lost, or has stopped it.
pub fn lost(lost: Lost) -> Failure {
    match lost {
        Lost::Halted(_) => Failure::Guard(lost.to_string()),
        Lost::Died | Lost::Silent => Failure::Device(lost.to_string()),
    }
}

/// An emulated finger has no guardian.
impl Watched for EmulatedDisplay {
    fn beat(&mut self, _now: Instant) -> Result<(), Failure> {
        Ok(())
    }

    fn abandon(&mut self, _cause: &str) {}

    fn part(&mut self, off: Result<(), String>, _failed: bool) -> Result<(), String> {
        off
    }
}

/// A session between its ends that has not begun. It keeps readings for views where it is `watched`; `taxels` are
/// recorded.
pub(super) fn assemble<S: Sensed, D: Watched>(
    (projector, drives): (Projector, usize),
    ends: (S, D),
    truth: Truth,
    taxels: Option<Readings>,
    watched: bool,
) -> Session<S, D> {
    let layout = projector.layout();
    let mut recorder = Recorder::new(truth, layout);
    recorder.counts = watched.then(Vec::new);
    recorder.readings = Some(Readings::sampled(layout, drives));
    recorder.taxels = taxels;
    Session::new(
        projector,
        ends,
        Policy::REAL,
        recorder,
        Some(clock::elapsed),
    )
}

/// Takes the display's part of a turn at `now`: its guardian is there, and heat is reserved ahead.
///
/// # Errors
/// The failure that ends the run.
pub fn beat<S: SkinEnd, D: Watched>(
    session: &mut Session<S, D>,
    now: Instant,
) -> Result<(), Failure> {
    let (display, projector, _) = session.all();
    display.beat(now)?;
    match display.ledger() {
        Some((heat, fingertip)) => heat.beat(fingertip, now, projector.guard()),
        None => Ok(()),
    }
}

/// Books heat of all sessions of a bench at a time, where they have a ledger.
fn book<'a, S: SkinEnd + 'a, D: Watched + 'a>(
    sessions: impl Iterator<Item = &'a mut Session<S, D>>,
    at: Instant,
    book: impl FnOnce(&Heat, &[(Instant, &Guard)]) -> Result<(), Failure>,
) -> Result<(), Failure> {
    let mut heat = None;
    let guards = sessions.map(|session| {
        let ledger = session.display().ledger();
        heat = ledger.map(|(heat, _)| Arc::clone(heat));
        (at, session.projector().guard())
    });
    let guards: Vec<(Instant, &Guard)> = guards.collect();
    heat.map_or(Ok(()), |heat| book(&heat, &guards))
}

/// Books the sessions' true heat until `at`, where everything is known to be `off`.
pub(super) fn settle<'a, S: SkinEnd + 'a, D: Watched + 'a>(
    sessions: impl Iterator<Item = &'a mut Session<S, D>>,
    at: Instant,
    off: bool,
) -> Result<(), Failure> {
    book(sessions, at, |heat, guards| heat.end(guards, off))
}

/// Checks before a turn for time that nobody saw, for the display's guardian, for events of its buses. Returns whether
/// the run may go on. A stop for unseen time calls `at_once` before it switches anything off.
pub(super) fn goes_on<S: Sensed, D: Watched>(
    session: &mut Session<S, D>,
    watch: &mut Watch,
    now: Instant,
    at_once: impl FnOnce(),
) -> bool {
    if let Some(unseen) = watch.look(now) {
        // Other loops must not wait for this one's bus.
        at_once();
        if !session.unseen(now, unseen.uncounted(), &unseen.to_string()) {
            return false;
        }
    }
    if let Err(failure) = beat(session, now) {
        session.set_failure(failure);
        return false;
    }
    while let Some(note) = session.skin().note() {
        session.recorder().note(note.at, note.text);
    }
    true
}

/// Starts the outputs of all sessions of a bench: boards that were found driving are noted, heat is reserved,
/// everything is off and set up. Returns the time of the first turn.
///
/// # Errors
/// [`Failure`] for outputs that cannot be started, or heat that cannot be kept; the guardian has been told.
pub fn begin<S: SkinEnd, D: Watched>(
    sessions: &mut [Session<S, D>],
    clock: RunClock,
) -> Result<Instant, Failure> {
    for session in &mut *sessions {
        let found = session.display().found().to_owned();
        for line in found.lines() {
            let text = format!("{line}; switched off");
            session.recorder().note(Instant::ZERO, text);
        }
    }
    let held = book(sessions.iter_mut(), clock.now(), Heat::begin);
    if let Err(refused) = held {
        for session in sessions {
            // Nothing is on yet: the good-bye cannot fail in a way that matters more than this.
            let _ = session.display().part(Ok(()), true);
        }
        return Err(refused);
    }
    let started = start(sessions, clock);
    started.inspect_err(|_| {
        // Nothing was driven. Heat that cannot be booked as such stays reserved.
        let _ = settle(sessions.iter_mut(), clock.now(), true);
    })
}

fn start<S: SkinEnd, D: Watched>(
    sessions: &mut [Session<S, D>],
    clock: RunClock,
) -> Result<Instant, Failure> {
    for session in &mut *sessions {
        session.display().meet()?;
    }
    // All have the same time: an event that boards have in common is told once.
    let now = clock.now();
    let mut ready = now;
    for session in sessions {
        let started = session.start(now).map_err(|error| {
            let display = session.display();
            let cause = display.explain(&error);
            display.abandon(&cause);
            Failure::Device(cause)
        });
        ready = ready.max(started?);
    }
    Ok(ready)
}

/// Switches everything off, and takes leave of the guardian of the only session of a bench. Returns the time of that.
/// Without a guardian the session stays until everything is off.
pub fn leave<S: SkinEnd, D: Watched>(session: &mut Session<S, D>, clock: RunClock) -> Instant {
    let left = switch_off(session, clock.now());
    let (end, is_off) = part(session, clock, left, |_| false);
    if let Err(failure) = settle(std::iter::once(&mut *session), end, is_off) {
        session.recorder().note(end, failure.to_string());
        session.set_failure(failure);
    }
    end
}

/// Takes leave of the guardian of a session that was switched off, or was `left` on for this cause. Returns the time of
/// that, and whether everything is known to be off. Outputs that are on are tried again for as long as `tries_on`
/// allows, which looks around meanwhile, and without a guardian until they are off.
pub(super) fn part<S: SkinEnd, D: Watched>(
    session: &mut Session<S, D>,
    clock: RunClock,
    left: Option<String>,
    mut tries_on: impl FnMut(&mut Session<S, D>) -> bool,
) -> (Instant, bool) {
    let (mut end, first) = (session.now(), left.clone());
    let (mut left, mut is_alone) = (left, false);
    while let Some(cause) = left.take_if(|_| tries_on(session) || !session.display().is_guarded()) {
        if !session.display().is_guarded() && !std::mem::replace(&mut is_alone, true) {
            let text =
                format!("no guardian is left, and not everything is off: {cause}; trying on");
            session.recorder().note(end, text);
        }
        clock.sleep_until(clock.now() + Policy::REAL.retry);
        end = clock.now();
        left = switch_off_again(session, end);
    }
    let failed = session.failure().is_some();
    let off = left.map_or(Ok(()), |cause| Err(left_on(session, cause)));
    let parted = session.display().part(off, failed);
    let is_off = parted.is_ok();
    if let Err(cause) = parted {
        // The guardian has tried meanwhile, and goes on.
        session.still_on();
        let text = format!("not everything is known to be off: {cause}");
        session.recorder().note(end, text);
        session.set_failure(Failure::Device(cause));
    }
    if let Some(cause) = first {
        session.set_failure(Failure::Device(cause));
    }
    (end, is_off)
}

/// Switches everything of a session off. Returns the reason why it may be on.
pub(super) fn switch_off<S: SkinEnd, D: DisplayEnd>(
    session: &mut Session<S, D>,
    end: Instant,
) -> Option<String> {
    let error = session.switch_off(end).err()?;
    Some(session.display().explain(&error))
}

/// Tries once more to switch off outputs that could not be switched off. Returns the reason why they may be on.
fn switch_off_again<S: SkinEnd, D: DisplayEnd>(
    session: &mut Session<S, D>,
    now: Instant,
) -> Option<String> {
    let end = session.display();
    if let Err(error) = end.parts().0.start(now) {
        return Some(end.explain(&error));
    }
    let (_, oe) = end.parts();
    oe.set_enabled(now, true);
    let note = "switched off, its bus is back";
    session.recorder().note(now, note.into());
    session.settle();
    None
}

/// Words for wires that may be on since they could not be switched off, with their time on if that is too long.
fn left_on<S: SkinEnd, D: DisplayEnd>(session: &mut Session<S, D>, cause: String) -> String {
    session.still_on();
    match session.overrun() {
        Some(overrun) => format!("{overrun}; {cause}"),
        None => cause,
    }
}
