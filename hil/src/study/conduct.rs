//! A session between its record, a bench and the two pages, or a simulated person.

use std::time::Duration;

use palpate_buses::signals::Signals;
use palpate_run::Failure;
use palpate_study::{
    Ask, Known, Line, Noted, Person, Played, Reply, Said, Session, Step, Stimulus, Trial,
};
use serde_json::{Value, json};

use super::folder::Writing;
use super::player::{Off, Player, Went};
use palpate_live::clock;
use palpate_live::serve::{Desk, Heard};

/// How often signals are looked for.
const GLANCE: Duration = Duration::from_millis(50);
/// Space around the display's wires on a page, mm.
const MARGIN_MM: f64 = 9.0;

/// How a session ended.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Ended {
    /// Everything was answered.
    Done,
    /// The participant did not agree.
    Declined,
    /// STOP; what of it is known.
    Stopped(String),
    /// A signal came.
    Signal(&'static str),
}

/// Who answers.
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
    /// Where it stands.
    pub session: Session,
    /// Its record.
    pub writing: Writing,
    /// The bench.
    pub player: Player,
    /// Who answers.
    pub answers: Answers<'a>,
    /// The dose that was planned, as a share.
    pub dose: f64,
    /// Milliseconds since 1970 at which the session began.
    pub began_unix_ms: u64,
    /// What a simulated person knows of paths.
    pub known: Known,
    /// Whether the participant has said that it may go on; after a void trial that is asked again.
    pub begun: bool,
}

/// What came of a step.
enum Came {
    Reply(Reply, Option<Played>),
    Stopped(String, Option<Played>),
    Signal(&'static str),
}

/// Conducts a session to its end.
///
/// # Errors
/// [`Failure`] of the bench, or of the disk: no trial begins before the last answer is on it.
pub fn conduct(mut of: Conducting<'_>) -> Result<Ended, Failure> {
    let signals = Signals::catch().map_err(|e| Failure::Device(format!("signals: {e}")))?;
    let protocol = of.session.protocol().clone();
    if let Answers::Page(desk) = of.answers
        && !of.is_over()
        && let Some(came) = of.begin(desk, &signals)?
    {
        return match came {
            Came::Signal(name) => Ok(Ended::Signal(name)),
            Came::Stopped(text, played) => of.end(text, played),
            Came::Reply(..) => Ok(Ended::Done),
        };
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
            of.writing.tables(&protocol)?;
            return Ok(ended);
        }
        match of.step(&signals)? {
            Came::Reply(reply, trial) => {
                if let Err(why) = of.session.check(&reply) {
                    of.note(Line::Note, format!("a reply that is none: {why}"))?;
                    continue;
                }
                let line = Line::Reply(Said {
                    at_ms: of.now_ms(),
                    reply: reply.clone(),
                    trial,
                });
                of.writing.add(line)?;
                of.writing.tables(&protocol)?;
                of.begun &= !matches!(reply, Reply::Void(_));
                of.session
                    .take(&reply)
                    .map_err(|e| Failure::Input(e.to_string()))?;
            }
            Came::Stopped(text, played) => return of.end(text, played),
            Came::Signal(name) => return Ok(Ended::Signal(name)),
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
            Answers::Page(_) => (clock::unix_us() / 1000).saturating_sub(self.began_unix_ms),
            Answers::Person(_) => self.player.until_ms(),
        }
    }

    /// STOP: what was going on is void, and the session is over for now.
    fn end(&mut self, text: String, trial: Option<Played>) -> Result<Ended, Failure> {
        self.show(json!({ "screen": "stopped" }));
        if matches!(self.session.step(), Step::Trial(_)) {
            let reply = Reply::Void("STOP".into());
            let line = Line::Reply(Said {
                at_ms: self.now_ms(),
                reply: reply.clone(),
                trial,
            });
            self.writing.add(line)?;
            self.session
                .take(&reply)
                .map_err(|e| Failure::Input(e.to_string()))?;
        }
        self.note(Line::Stopped, text.clone())?;
        self.tell(Some(&text))?;
        Ok(Ended::Stopped(text))
    }

    /// Waits until the participant's page is there and its person says that it may begin.
    fn begin(&mut self, desk: &Desk, signals: &Signals) -> Result<Option<Came>, Failure> {
        let view = desk.show(json!({ "screen": "begin" }));
        loop {
            match self.wait(desk, view, signals)? {
                Came::Reply(Reply::Read, _) => {
                    self.begun = true;
                    return Ok(None);
                }
                Came::Reply(..) => {}
                came => return Ok(Some(came)),
            }
        }
    }

    fn note(&mut self, line: fn(Noted) -> Line, text: String) -> Result<(), Failure> {
        let at_ms = self.now_ms();
        self.writing.add(line(Noted { at_ms, text }))
    }

    fn show(&self, view: Value) -> u64 {
        match self.answers {
            Answers::Page(desk) => desk.show(view),
            Answers::Person(_) => 0,
        }
    }

    /// What the experimenter sees.
    fn tell(&self, said: Option<&str>) -> Result<(), Failure> {
        let Answers::Page(desk) = self.answers else {
            return Ok(());
        };
        let (done, all) = self.session.progress();
        let rows = self.player.used(self.now_ms())?.rows();
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
        desk.tell(json!({
            "protocol": self.session.protocol().name,
            "participant": about.map(|about| about.participant),
            "bench": about.map(|about| &about.bench),
            "source": about.map(|about| &about.source),
            "done": done,
            "all": all,
            "void": void,
            "step": step_name(self.session.step()),
            "trial": trial,
            "lay": present,
            "rows": rows,
            "planned": self.dose,
            "seated": desk.is_seated(),
            "said": said,
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

    /// A step: shown, played where it is a trial, and answered.
    fn step(&mut self, signals: &Signals) -> Result<Came, Failure> {
        let step = self.session.step().clone();
        let Step::Trial(trial) = &step else {
            return match &self.answers {
                Answers::Person(person) => {
                    let reply = person.reply(self.session.protocol(), &step, &self.known);
                    Ok(Came::Reply(reply.unwrap_or(Reply::Read), None))
                }
                Answers::Page(desk) => {
                    let desk = *desk;
                    let view = desk.show(self.screen(&step));
                    self.wait(desk, view, signals)
                }
            };
        };
        match self.answers {
            Answers::Person(_) => self.simulated(&step, trial),
            Answers::Page(desk) => self.trial(desk, trial, signals),
        }
    }

    fn simulated(&mut self, step: &Step, trial: &Trial) -> Result<Came, Failure> {
        let mut played = Played::of(trial);
        for stimulus in &trial.intervals {
            let pause_ms = (self.session.protocol().pause_s * 1e3) as u64;
            let (interval, _) = self
                .player
                .play(stimulus, self.player.until_ms() + pause_ms)?;
            if let Stimulus::Condition(name) = stimulus {
                self.known.paths.insert(name.clone(), interval.path.clone());
            }
            played.intervals.push(interval);
        }
        played.asked_ms = self.now_ms();
        let reply = match &self.answers {
            Answers::Person(person) => person.reply(self.session.protocol(), step, &self.known),
            Answers::Page(_) => None,
        };
        Ok(Came::Reply(reply.unwrap_or(Reply::Read), Some(played)))
    }

    /// A trial on the page: a pause, its intervals, its question.
    fn trial(&mut self, desk: &Desk, trial: &Trial, signals: &Signals) -> Result<Came, Failure> {
        let mut played = Played::of(trial);
        let void =
            |why: &str, played: Played| Ok(Came::Reply(Reply::Void(why.into()), Some(played)));
        // A page that is not there yet is waited for; nothing is played for it.
        if !(self.begun && desk.is_seated())
            && let Some(came) = self.begin(desk, signals)?
        {
            return Ok(came);
        }
        let waiting = desk.show(json!({ "screen": "wait" }));
        if self.laid(trial).is_some()
            && let Some(came) = self.wait_laid(desk, signals)?
        {
            return Ok(came);
        }
        for (number, stimulus) in trial.intervals.iter().enumerate() {
            let pause = Duration::from_secs_f64(self.session.protocol().pause_s);
            match self.wait_until(desk, waiting, signals, Some(pause))? {
                Some(Came::Reply(Reply::Void(why), _)) => return void(&why, played),
                Some(came) => return Ok(came),
                None => {}
            }
            let number = number + 1;
            let of = trial.intervals.len();
            desk.show(json!({ "screen": "play", "interval": number, "of": of }));
            let (interval, went) = self.player.play(stimulus, self.now_ms())?;
            played.intervals.push(interval);
            match went {
                Went::Whole => {}
                Went::Stopped(at) => return Ok(Came::Stopped(off(desk, at), Some(played))),
                Went::Latched(at, text) => {
                    let text = format!("{}; {text}", off(desk, at));
                    return Ok(Came::Stopped(text, Some(played)));
                }
            }
            desk.show(json!({ "screen": "wait" }));
            self.tell(None)?;
        }
        played.asked_ms = self.now_ms();
        let view = desk.show(self.screen(self.session.step()));
        loop {
            match self.wait(desk, view, signals)? {
                Came::Reply(Reply::Answer(answer), _) if trial.ask.check(&answer).is_ok() => {
                    return Ok(Came::Reply(Reply::Answer(answer), Some(played)));
                }
                Came::Reply(Reply::Void(why), _) => return void(&why, played),
                Came::Reply(..) => {}
                came => return Ok(came),
            }
        }
    }

    /// Waits until what the experimenter lays under the finger lies there.
    fn wait_laid(&mut self, desk: &Desk, signals: &Signals) -> Result<Option<Came>, Failure> {
        loop {
            if let Some(name) = signals.caught() {
                return Ok(Some(Came::Signal(name)));
            }
            match desk.hear(GLANCE) {
                Some(Heard::Laid) => return Ok(None),
                Some(Heard::Stop) => return Ok(Some(Came::Stopped(off(desk, clock::now()), None))),
                Some(Heard::Note(text)) => self.note(Line::Note, text)?,
                _ => {}
            }
        }
    }

    /// Waits for a reply to a view.
    fn wait(&mut self, desk: &Desk, view: u64, signals: &Signals) -> Result<Came, Failure> {
        loop {
            if let Some(came) = self.wait_until(desk, view, signals, None)? {
                return Ok(came);
            }
        }
    }

    /// The same for so long at most. A lost page is a void trial, if one is open.
    fn wait_until(
        &mut self,
        desk: &Desk,
        view: u64,
        signals: &Signals,
        most: Option<Duration>,
    ) -> Result<Option<Came>, Failure> {
        let until = most.map(|most| clock::now() + most);
        loop {
            if let Some(name) = signals.caught() {
                return Ok(Some(Came::Signal(name)));
            }
            let left = until.map(|until| until.saturating_duration_since(clock::now()));
            if left.is_some_and(|left| left.is_zero()) {
                return Ok(None);
            }
            let is_trial = matches!(self.session.step(), Step::Trial(_));
            match desk.hear(left.map_or(GLANCE, |left| left.min(GLANCE))) {
                Some(Heard::Reply(to, reply)) if to == view && !matches!(reply, Reply::Void(_)) => {
                    return Ok(Some(Came::Reply(reply, None)));
                }
                Some(Heard::Stop) => return Ok(Some(Came::Stopped(off(desk, clock::now()), None))),
                Some(Heard::Note(text)) => self.note(Line::Note, text)?,
                Some(Heard::Void(why)) if is_trial => {
                    return Ok(Some(Came::Reply(Reply::Void(why), None)));
                }
                Some(Heard::Lost) if is_trial => {
                    let why = "the participant's page was lost".to_owned();
                    return Ok(Some(Came::Reply(Reply::Void(why), None)));
                }
                _ => {}
            }
        }
    }

    /// What the participant sees of a step. Nothing of it names a condition, a wire or a level.
    fn screen(&self, step: &Step) -> Value {
        let protocol = self.session.protocol();
        let (done, all) = self.session.progress();
        let mut view = match step {
            Step::Consent => json!({ "screen": "consent", "text": protocol.consent }),
            Step::Instructions => {
                json!({ "screen": "instructions", "text": protocol.instructions })
            }
            Step::Question(number) => {
                let question = &protocol.questions[*number];
                json!({ "screen": "question", "text": question.text, "choices": question.choices })
            }
            Step::Break => json!({ "screen": "break", "seconds": protocol.break_s }),
            Step::Trial(trial) => self.asked(trial),
            Step::Done => json!({ "screen": "done" }),
            Step::Declined => json!({ "screen": "declined" }),
        };
        view["part"] = json!(done as f64 / all.max(1) as f64);
        view
    }

    fn asked(&self, trial: &Trial) -> Value {
        match &trial.ask {
            Ask::Interval(question) => json!({ "screen": "interval", "text": question }),
            Ask::Which(question) => json!({ "screen": "interval", "text": question }),
            Ask::Place => {
                json!({ "screen": "place", "text": "Where was it?", "frame_mm": self.frame() })
            }
            Ask::Path => {
                json!({ "screen": "path", "text": "Draw the path that you felt.", "frame_mm": self.frame() })
            }
            Ask::Ratings(scales) => {
                let scales: Vec<Value> = scales
                    .iter()
                    .map(|s| json!({ "name": s.name, "low": s.low, "high": s.high }))
                    .collect();
                json!({ "screen": "ratings", "text": "How was it?", "scales": scales })
            }
        }
    }

    /// Left, bottom, right and top of what a page shows, mm.
    fn frame(&self) -> [f64; 4] {
        let wires = self.player.stimuli().wires_mm();
        let over = |axis: usize, pick: fn(f64, f64) -> f64, from: f64| {
            wires.iter().map(|wire| wire[axis]).fold(from, pick)
        };
        let (low, high) = (f64::INFINITY, f64::NEG_INFINITY);
        [
            over(0, f64::min, low) - MARGIN_MM,
            over(1, f64::min, low) - MARGIN_MM,
            over(0, f64::max, high) + MARGIN_MM,
            over(1, f64::max, high) + MARGIN_MM,
        ]
    }
}

/// What is known of a STOP.
fn off(desk: &Desk, at: Off) -> String {
    let took = desk
        .stopped()
        .map(|heard| at.saturating_duration_since(heard));
    let ms = took.map_or(0, |took| took.as_millis());
    format!("STOP on a page; outputs off {ms} ms after it was heard")
}

const fn step_name(step: &Step) -> &'static str {
    match step {
        Step::Consent => "consent",
        Step::Instructions => "instructions",
        Step::Question(_) => "question",
        Step::Break => "break",
        Step::Trial(_) => "trial",
        Step::Done => "done",
        Step::Declined => "declined",
    }
}

/// A trial as the experimenter reads it.
fn words(trial: &Trial) -> String {
    let played = trial.intervals.iter().map(|stimulus| match stimulus {
        Stimulus::Silence => "nothing".to_owned(),
        Stimulus::Wire { wire, level_db } => format!("wire {wire} at {level_db:.1} dB"),
        Stimulus::Condition(name) => name.clone(),
    });
    let played: Vec<String> = played.collect();
    let practice = if trial.practice { ", practice" } else { "" };
    let again = match trial.attempt {
        0 => String::new(),
        n => format!(", begun for the {}. time", n + 1),
    };
    format!(
        "{}{practice}{again}: {}",
        trial.task.name(),
        played.join(", then ")
    )
}
