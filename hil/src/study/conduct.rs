//! A session between its record, a bench and the two pages, or a simulated person.

use std::time::Duration;

use palpate_buses::signals::Signals;
use palpate_run::Failure;
use palpate_study::{
    Known, Line, Noted, Passing, Person, Played, Playing, Reply, Said, Session, Step, Stimulus,
    Trial,
};
use serde_json::{Value, json};

use super::clock::SessionClock;
use super::folder::Writing;
use super::player::{Off, Player, Went};
use super::screens::{screen, step_name, words};
use palpate_live::clock;
use palpate_live::serve::{Desk, Heard};

/// Time between looks for signals.
const GLANCE: Duration = Duration::from_millis(50);
/// Notes that a record takes at most.
const MOST_NOTES: usize = 1000;

/// End of a session.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Ended {
    /// Everything was answered.
    Done,
    /// The participant did not agree.
    Declined,
    /// STOP, with the time from its arrival to outputs that are off.
    Stopped(String),
    /// A signal came.
    Signal(&'static str),
}

/// Source of the answers.
#[derive(Debug)]
pub enum Answers<'a> {
    /// A person in front of a page.
    Page(&'a Desk),
    /// A simulated one, as fast as the bench is emulated.
    Person(Box<Person>),
}

/// A session that is conducted.
#[derive(Debug)]
pub struct Conducting<'a> {
    /// State of the session.
    pub session: Session,
    /// Record of the session.
    pub writing: Writing,
    /// The bench.
    pub player: Player,
    /// Source of the answers.
    pub answers: Answers<'a>,
    /// The dose that was planned, as a share.
    pub dose: f64,
    /// Clock of the session, for a person who answers.
    pub clock: SessionClock,
    /// Knowledge of paths for a simulated person.
    pub known: Known,
    /// `true` once the participant has said that the session may go on; after a void trial that is asked again.
    pub begun: bool,
}

/// Result of a step.
enum Came {
    Reply(Reply),
    End(End),
}

/// Cause that ends a session before all is answered.
enum End {
    Stopped(String),
    Signal(&'static str),
    /// The bench failed, or passed a limit.
    Failed(Failure),
}

/// Conducts a session to its end.
///
/// # Errors
/// [`Failure`] of the bench, or of the disk: no trial begins before the last answer is on it.
pub fn conduct(mut of: Conducting<'_>) -> Result<Ended, Failure> {
    let signals = Signals::catch().map_err(|e| Failure::Device(format!("signals: {e}")))?;
    // Before anything begins the experimenter sees what it will be.
    of.tell(None)?;
    if let Answers::Page(desk) = of.answers
        && !of.is_over()
        && let Some(end) = of.begin(desk, &signals)?
    {
        return of.end(end, None);
    }
    loop {
        of.tell(None)?;
        let ended = match of.session.step() {
            Step::Done => Some((Ended::Done, "done")),
            Step::Declined => Some((Ended::Declined, "declined")),
            _ => None,
        };
        if let Some((ended, screen)) = ended {
            of.show(json!({ "screen": screen }));
            of.writing.tables(of.session.protocol())?;
            return Ok(ended);
        }
        let (came, trial) = of.step(&signals)?;
        let reply = match came {
            Came::Reply(reply) => reply,
            Came::End(end) => return of.end(end, trial),
        };
        match of.session.check(&reply) {
            Ok(()) => of.reply(reply, trial)?,
            Err(why) => of.note(format!("a reply that is none: {why}"))?,
        }
    }
}

impl Conducting<'_> {
    fn is_over(&self) -> bool {
        matches!(self.session.step(), Step::Done | Step::Declined)
    }

    /// Milliseconds since the session began; of a simulated person those that the bench has played.
    fn now_ms(&self) -> u64 {
        match self.answers {
            Answers::Page(_) => self.clock.now_ms(),
            Answers::Person(_) => self.player.until_ms(),
        }
    }

    /// The time of a line that is written now.
    fn stamp(&self) -> u64 {
        self.writing.stamp(self.now_ms())
    }

    /// Writes a reply with what was played before it, and goes on.
    fn reply(&mut self, reply: Reply, trial: Option<Played>) -> Result<(), Failure> {
        let line = Line::Reply(Said {
            at_ms: self.stamp(),
            reply: reply.clone(),
            trial,
        });
        self.writing.add(line)?;
        self.writing.tables(self.session.protocol())?;
        self.begun &= !matches!(reply, Reply::Void(_));
        let taken = self.session.take(&reply);
        taken.map_err(|e| Failure::Input(e.to_string()))
    }

    /// Ends the session for now. A trial that was open is void, and what was played of it stays in the record.
    fn end(&mut self, end: End, trial: Option<Played>) -> Result<Ended, Failure> {
        let (why, is_stop) = match &end {
            End::Stopped(_) => ("STOP".to_owned(), true),
            End::Signal(name) => ((*name).to_owned(), false),
            End::Failed(failure) => (failure.to_string(), false),
        };
        if is_stop {
            self.show(json!({ "screen": "stopped" }));
        }
        let was_played = trial.as_ref().is_some_and(|of| !of.intervals.is_empty());
        if matches!(self.session.step(), Step::Trial(_)) && (is_stop || was_played) {
            self.reply(Reply::Void(why), trial)?;
        }
        match end {
            End::Stopped(text) => {
                let line = Line::Stopped(Noted {
                    at_ms: self.stamp(),
                    text: text.clone(),
                });
                self.writing.add(line)?;
                self.tell(Some(&text))?;
                Ok(Ended::Stopped(text))
            }
            End::Signal(name) => Ok(Ended::Signal(name)),
            End::Failed(failure) => Err(failure),
        }
    }

    /// Waits until the participant's page is there and its person says that it may begin, unless the session ends before.
    fn begin(&mut self, desk: &Desk, signals: &Signals) -> Result<Option<End>, Failure> {
        let view = desk.show(json!({ "screen": "begin" }));
        loop {
            match self.wait(desk, view, signals)? {
                Came::Reply(Reply::Read) => {
                    self.begun = true;
                    self.tell(None)?;
                    return Ok(None);
                }
                Came::Reply(_) => {}
                Came::End(end) => return Ok(Some(end)),
            }
        }
    }

    /// Tells whether the record takes no more notes.
    fn is_full(&self) -> bool {
        let lines = self.writing.record.iter().flat_map(|record| &record.lines);
        let notes = lines.filter(|line| matches!(line, Line::Note(_)));
        notes.count() >= MOST_NOTES
    }

    /// Writes a note, unless there are too many.
    fn note(&mut self, text: String) -> Result<(), Failure> {
        if self.is_full() {
            return Ok(());
        }
        let at_ms = self.stamp();
        self.writing.add(Line::Note(Noted { at_ms, text }))
    }

    fn show(&self, view: Value) -> u64 {
        match self.answers {
            Answers::Page(desk) => desk.show(view),
            Answers::Person(_) => 0,
        }
    }

    /// Screen of the participant at the present step.
    fn screen(&self) -> Value {
        screen(&self.session, self.player.stimuli().wires_mm())
    }

    /// Tells the experimenter the state of the session.
    fn tell(&self, said: Option<&str>) -> Result<(), Failure> {
        let Answers::Page(desk) = self.answers else {
            return Ok(());
        };
        let (done, all) = self.session.progress();
        let rows = self.player.used(self.now_ms())?;
        let about = self.writing.record.as_ref().map(|record| &record.about);
        let void = self
            .writing
            .record
            .iter()
            .flat_map(|record| record.replies());
        let void = void
            .filter(|said| matches!(said.reply, Reply::Void(_)))
            .count();
        let (trial, present) = match self.session.step() {
            Step::Trial(trial) => (Some(words(trial)), self.laid(trial)),
            _ => (None, None),
        };
        let full = "The record takes no more notes.";
        desk.tell(json!({
            "protocol": self.session.protocol().name,
            "participant": about.map(|about| about.participant),
            "bench": about.map(|about| &about.bench),
            "source": about.map(|about| &about.source),
            "done": done,
            "all": all,
            "void": void,
            "begun": self.begun,
            "step": step_name(self.session.step()),
            "trial": trial,
            "lay": present,
            "rows": rows,
            "planned": self.dose,
            "seated": desk.is_seated(),
            "said": said.or(self.is_full().then_some(full)),
        }));
        Ok(())
    }

    fn laid(&self, trial: &Trial) -> Option<String> {
        let mut laid = trial
            .intervals
            .iter()
            .filter_map(|s| self.player.stimuli().present(s));
        laid.next().map(str::to_owned)
    }

    /// Takes a step: shows it, plays it where it is a trial, and
    /// has it answered. Returns what was played, however it ended.
    fn step(&mut self, signals: &Signals) -> Result<(Came, Option<Played>), Failure> {
        let step = self.session.step().clone();
        let Step::Trial(trial) = &step else {
            let came = match &self.answers {
                Answers::Person(person) => {
                    let reply = person.reply(self.session.protocol(), &step, &self.known);
                    Came::Reply(reply.unwrap_or(Reply::Read))
                }
                Answers::Page(desk) => {
                    let desk = *desk;
                    let view = desk.show(self.screen());
                    self.wait(desk, view, signals)?
                }
            };
            return Ok((came, None));
        };
        if let Some(end) = self.pass()? {
            return Ok((Came::End(end), None));
        }
        let mut played = Played::new(trial);
        let came = match self.answers {
            Answers::Person(_) => self.simulated(&step, trial, &mut played)?,
            Answers::Page(desk) => self.trial(desk, trial, signals, &mut played)?,
        };
        Ok((came, Some(played)))
    }

    /// Passes cold wires before the first trial. The participant reads of it. The record has its bursts before they are
    /// played, and a note afterwards.
    fn pass(&mut self) -> Result<Option<End>, Failure> {
        let Some(interval) = self.player.due_pass(self.now_ms())? else {
            return Ok(None);
        };
        let at_ms = self.stamp();
        self.writing
            .add(Line::Passing(Passing { at_ms, interval }))?;
        self.show(json!({ "screen": "pass" }));
        match self.player.pass(self.now_ms()) {
            Ok(Some(told)) => self.note(format!("hot pass: {told}"))?,
            Ok(None) => {}
            Err(Failure::Stopped(text) | Failure::Guard(text)) => {
                return Ok(Some(End::Stopped(text)));
            }
            Err(failure) => return Ok(Some(End::Failed(failure))),
        }
        Ok(None)
    }

    /// Plays an interval `after_ms` from now. It is in the record before it begins, with its largest bookings.
    fn play(
        &mut self,
        stimulus: &Stimulus,
        after_ms: u64,
        played: &mut Played,
    ) -> Result<Went, Failure> {
        let booking = self.player.booking(stimulus, self.now_ms() + after_ms)?;
        if let Some(interval) = booking {
            let line = Line::Playing(Playing {
                at_ms: self.stamp(),
                number: played.number,
                attempt: played.attempt,
                interval,
            });
            self.writing.add(line)?;
        }
        let (interval, went) = self.player.play(stimulus, self.now_ms() + after_ms)?;
        played.intervals.push(interval);
        Ok(went)
    }

    fn simulated(
        &mut self,
        step: &Step,
        trial: &Trial,
        played: &mut Played,
    ) -> Result<Came, Failure> {
        let pause_ms = (self.session.protocol().pause_s * 1e3) as u64;
        for stimulus in &trial.intervals {
            if let Went::Failed(failure) = self.play(stimulus, pause_ms, played)? {
                return Ok(Came::End(End::Failed(failure)));
            }
            if let (Stimulus::Condition(name), Some(interval)) = (stimulus, played.intervals.last())
            {
                self.known.paths.insert(name.clone(), interval.path.clone());
            }
            self.known.feel(stimulus, self.player.sensed());
        }
        played.asked_ms = self.now_ms();
        let reply = match &self.answers {
            Answers::Person(person) => person.reply(self.session.protocol(), step, &self.known),
            Answers::Page(_) => None,
        };
        Ok(Came::Reply(reply.unwrap_or(Reply::Read)))
    }

    /// A trial on the page: a pause, its intervals, its question.
    fn trial(
        &mut self,
        desk: &Desk,
        trial: &Trial,
        signals: &Signals,
        played: &mut Played,
    ) -> Result<Came, Failure> {
        // A page that is not there yet is waited for; nothing is played for it.
        if !(self.begun && desk.is_seated())
            && let Some(end) = self.begin(desk, signals)?
        {
            return Ok(Came::End(end));
        }
        desk.show(json!({ "screen": "wait" }));
        if self.laid(trial).is_some()
            && let Some(end) = self.wait_laid(desk, signals)?
        {
            return Ok(Came::End(end));
        }
        let pause = Duration::from_secs_f64(self.session.protocol().pause_s);
        for (number, stimulus) in trial.intervals.iter().enumerate() {
            if let Some(came) = self.wait_until(desk, None, signals, Some(pause))? {
                return Ok(came);
            }
            let number = number + 1;
            let of = trial.intervals.len();
            desk.show(json!({ "screen": "play", "interval": number, "of": of }));
            let end = match self.play(stimulus, 0, played)? {
                Went::Whole => None,
                Went::Stopped(at) => Some(End::Stopped(off(desk, at))),
                Went::Latched(at, text) => Some(End::Stopped(format!("{}; {text}", off(desk, at)))),
                Went::Failed(failure) => Some(End::Failed(failure)),
            };
            if let Some(end) = end {
                return Ok(Came::End(end));
            }
            desk.show(json!({ "screen": "wait" }));
            self.tell(None)?;
        }
        played.asked_ms = self.now_ms();
        let view = desk.show(self.screen());
        loop {
            match self.wait(desk, view, signals)? {
                Came::Reply(Reply::Answer(answer)) if trial.ask.check(&answer).is_err() => {}
                Came::Reply(Reply::Consent(_) | Reply::Read | Reply::Chosen(_)) => {}
                came => return Ok(came),
            }
        }
    }

    /// Waits until what the experimenter lays under the finger lies there.
    fn wait_laid(&mut self, desk: &Desk, signals: &Signals) -> Result<Option<End>, Failure> {
        loop {
            if let Some(name) = signals.caught() {
                return Ok(Some(End::Signal(name)));
            }
            match desk.hear(GLANCE) {
                Some(Heard::Laid) => return Ok(None),
                Some(Heard::Stop) => return Ok(Some(End::Stopped(off(desk, clock::now())))),
                Some(Heard::Note(text)) => self.note(text)?,
                _ => {}
            }
        }
    }

    /// Waits for a reply to a view.
    fn wait(&mut self, desk: &Desk, view: u64, signals: &Signals) -> Result<Came, Failure> {
        loop {
            if let Some(came) = self.wait_until(desk, Some(view), signals, None)? {
                return Ok(came);
            }
        }
    }

    /// Waits for a reply to a view, if there is one, for so long at most. A lost page is a void trial, if one is open.
    fn wait_until(
        &mut self,
        desk: &Desk,
        view: Option<u64>,
        signals: &Signals,
        most: Option<Duration>,
    ) -> Result<Option<Came>, Failure> {
        let until = most.map(|most| clock::now() + most);
        loop {
            if let Some(name) = signals.caught() {
                return Ok(Some(Came::End(End::Signal(name))));
            }
            let left = until.map(|until| until.saturating_duration_since(clock::now()));
            if left.is_some_and(|left| left.is_zero()) {
                return Ok(None);
            }
            let is_trial = matches!(self.session.step(), Step::Trial(_));
            match desk.hear(left.map_or(GLANCE, |left| left.min(GLANCE))) {
                Some(Heard::Reply(to, reply))
                    if view == Some(to) && !matches!(reply, Reply::Void(_)) =>
                {
                    return Ok(Some(Came::Reply(reply)));
                }
                Some(Heard::Stop) => {
                    return Ok(Some(Came::End(End::Stopped(off(desk, clock::now())))));
                }
                Some(Heard::Note(text)) => self.note(text)?,
                Some(Heard::Void(why)) if is_trial => {
                    return Ok(Some(Came::Reply(Reply::Void(why))));
                }
                Some(Heard::Lost) if is_trial => {
                    let why = "the participant's page was lost".to_owned();
                    return Ok(Some(Came::Reply(Reply::Void(why))));
                }
                _ => {}
            }
        }
    }
}

/// Account of a STOP: the time from its arrival to outputs that are off, ms.
fn off(desk: &Desk, at: Off) -> String {
    let took = desk
        .stopped()
        .map(|heard| at.saturating_duration_since(heard));
    let ms = took.map_or(0, |took| took.as_millis());
    format!("STOP on a page; outputs off {ms} ms after it was heard")
}
