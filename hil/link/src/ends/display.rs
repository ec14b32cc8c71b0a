//! `palpate-link display`: renders on a bench's outputs what comes of a finger. Projection clock, guard and deadlines are here;
//! nothing that a network does reaches an output but a fresh reading.

use std::sync::Arc;
use std::time::Duration as Wait;

use palpate_buses::pacer::RunClock;
use palpate_buses::signals::Signals;
use palpate_core::contact::Levels;
use palpate_core::skin::ModuleScan;
use palpate_core::units::{Duration, Instant};
use palpate_files::Setup;
use palpate_hil::output::note;
use palpate_hil::record::Journal;
use palpate_records::trace::Event;
use palpate_run::{Failure, HeldSession, Truth, Turn, header};

use super::heard::{Arrived, Heard, Waiting};
use super::inbox::Inbox;
use super::report::Report;
use super::shrunk::{Shrunk, levels};
use crate::budget::Stopwatch;
use crate::cli::DisplayArgs;
use crate::judge::{Bucket, Gate, Patience, Refusal};
use crate::message::{About, Body, Echo, Frame, VERSION, Wearer};
use crate::name::Name;
use crate::net::{self, Mode, Net};
use crate::records::{Felt, OFFSET_WORDS, failed, journal, layout_digest, session_of};

/// What waits for the loop at most: more than a turn of any skin.
const MOST_WAITING: usize = 512;
/// What is taken in one turn at most: a flood must not keep the loop from its guard.
const MOST_TAKEN: usize = 64;
/// A wearer speaks this often.
const BEAT: Duration = Duration::from_millis(100);
/// The first beats come faster: until publisher and wearer have heard of each other nothing is felt.
const FIRST_BEATS: Duration = Duration::from_millis(20);

/// The record states the bounds of the clocks this often, and at the end.
const STATED: Duration = Duration::from_millis(1000);

/// Runs it.
///
/// # Errors
/// [`Failure`] with its exit status.
pub fn run(args: &DisplayArgs) -> Result<(), Failure> {
    let setup = args.on.setup()?;
    if !setup.fingers.is_empty() {
        return Err(Failure::Input(format!(
            "bench `{}`: expected one display; a wearer of several fingers runs one `palpate-link display` per finger",
            setup.bench.value.name
        )));
    }
    let signals = Signals::catch().map_err(|e| Failure::Device(e.to_string()))?;
    let net = net::open(&args.at.at(), Mode::Peer, &signals).map_err(failed)?;
    // A certificate's name is the one that the access list knows.
    let wearer = net
        .name
        .as_ref()
        .map_or(Ok(args.wearer.clone()), |name| name.parse());
    let wearer: Name =
        wearer.map_err(|e| Failure::Input(format!("the certificate's name: {e}")))?;
    let clock = RunClock::start();
    let waiting: Waiting = Arc::new(Inbox::new(MOST_WAITING));
    let again = args
        .twice
        .twice
        .then(|| net::open(&args.at.at().beside(), Mode::Peer, &signals));
    let again = again.transpose().map_err(failed)?;
    let heard = Heard::begin((&net, again), (args, &wearer), clock, &waiting)?;
    let ended =
        Feeling::begin((args, &wearer), &setup, &net, clock, waiting)?.until(&signals, &heard);
    drop(heard);
    ended
}

/// The loop of a finger that feels what comes.
struct Feeling<'a> {
    args: &'a DisplayArgs,
    setup: &'a Setup,
    levels: Levels,
    clock: RunClock,
    waiting: Waiting,
    gate: Gate,
    session: HeldSession,
    journal: Journal,
    said: Wearer,
    felt: Felt,
    stopwatch: Stopwatch,
    report: Option<Report>,
    /// Compression of the publisher's scans, and whose they are.
    shrunk: Option<(u64, Shrunk)>,
    /// The publisher whose reference was asked for.
    asked: Option<u64>,
    asks: Bucket,
    /// Whether to ask with the next word.
    asks_now: bool,
    next_beat: Instant,
    next_stated: Instant,
    /// The time of the newest reading that was felt.
    newest: Option<Instant>,
}

impl<'a> Feeling<'a> {
    fn begin(
        (args, wearer): (&'a DisplayArgs, &Name),
        setup: &'a Setup,
        net: &Net,
        clock: RunClock,
        waiting: Waiting,
    ) -> Result<Self, Failure> {
        let levels = levels(setup, args.on.seed)?;
        let session = HeldSession::held(setup, args.on.seed, levels.clone(), Truth::Unknown)?;
        let projector = session.projector();
        let journal = journal(setup, args.on.seed, projector, &args.record, args.force)?;
        let layout = layout_digest(&setup.sensor.value);
        let modules = setup.sensor.value.modules.len();
        let own = session_of(&net.session);
        let report = (args.report.as_deref())
            .map(|path| Report::begin(path, args.force, header(setup, args.on.seed, projector)?))
            .transpose()?;
        Ok(Self {
            stopwatch: Stopwatch::new(setup, projector)?,
            report,
            felt: Felt::new(&args.finger, wearer.as_str(), own, clock.epoch_ns()),
            gate: Gate::new(Patience::of_modules(VERSION, layout, modules)),
            said: Wearer {
                version: VERSION,
                session: own,
                ..Wearer::default()
            },
            args,
            setup,
            levels,
            clock,
            waiting,
            session,
            journal,
            shrunk: None,
            asked: None,
            asks: Bucket::new(2, 2),
            asks_now: false,
            next_beat: Instant::ZERO,
            next_stated: Instant::ZERO,
            newest: None,
        })
    }

    fn until(mut self, signals: &Signals, heard: &Heard) -> Result<(), Failure> {
        let clock = self.clock;
        let started = self.session.start(clock.now());
        let mut next = started.map_err(|e| Failure::Device(e.to_string()))?;
        let end = self
            .args
            .seconds
            .map(|s| Instant::from_micros((s * 1e6) as u64));
        let mut stopped = None;
        loop {
            let now = clock.now();
            if end.is_some_and(|end| now >= end) {
                stopped.get_or_insert("its time is over".to_owned());
            }
            if let Some(signal) = signals.caught() {
                stopped = Some(format!("stopped by {signal}"));
            }
            if stopped.is_some() || self.journal.has_failed() {
                break;
            }
            self.take_all();
            self.felt.look(self.newest, now);
            if now >= next {
                match self.session.turn(now) {
                    Ok(Turn::Next(at)) => next = at,
                    Ok(Turn::Last) => break,
                    Err(failure) => {
                        self.session.set_failure(failure);
                        break;
                    }
                }
            }
            self.tell();
            if now >= self.next_beat {
                self.beat(now, heard);
            }
            let wait = next.min(self.next_beat).since(clock.now());
            self.waiting.wait(Wait::from_micros(wait.as_micros()));
        }
        let end = clock.now();
        let off = self.session.switch_off(end);
        self.said.stopped = stopped.unwrap_or_else(|| match self.session.failure() {
            Some(failure) => failure.to_string(),
            None => "a record cannot be written".into(),
        });
        self.beat(end, heard);
        self.state_offset(end);
        self.tell();
        off.map_err(|e| Failure::Device(format!("not everything is known to be off: {e}")))?;
        self.finish(end)
    }

    /// What there is to say when it is over.
    fn finish(mut self, end: Instant) -> Result<(), Failure> {
        let latency = self.stopwatch.finish();
        self.felt
            .finish(&self.gate, end, self.waiting.overflowed(), latency);
        self.journal.finish()?;
        if let Some(report) = self.report.take() {
            report.write(self.felt.latency(), self.session.recorder().driven, end)?;
        }
        if self.args.json {
            palpate_hil::output::print(|out| {
                serde_json::to_writer(&mut *out, &self.felt)?;
                writeln!(out)
            })?;
        } else if !self.args.quiet {
            note(&self.felt.line());
            note(&self.felt.latency().line());
        }
        self.session.take_failure().map_or(Ok(()), Err)
    }

    /// States the bounds of the clocks in the record.
    fn state_offset(&mut self, now: Instant) {
        self.next_stated = now + STATED;
        if let Some((low, high)) = self.gate.offset(now) {
            let text = format!("{OFFSET_WORDS}{low} to {high} us");
            self.session.recorder().note(now, text);
        }
    }

    /// Says how things are.
    fn beat(&mut self, now: Instant, heard: &Heard) {
        self.said.said_us = self.clock.now().as_micros();
        self.said.feels = self.gate.feels(now).unwrap_or(0);
        let step = if self.gate.offset(now).is_some() {
            BEAT
        } else {
            FIRST_BEATS
        };
        self.next_beat = now + step;
        if now >= self.next_stated {
            self.state_offset(now);
        }
        heard.voice.say(self.said.write().bytes().to_vec());
        if std::mem::take(&mut self.asks_now) {
            heard.voice.ask();
        }
        // News of refusals are said once.
        self.said.refused.clear();
        if self.newest.is_some_and(|at| now.since(at) < BEAT) {
            self.said.trouble.clear();
        }
    }

    /// Hands events to the records.
    fn tell(&mut self) {
        let (events, _) = self.session.drain();
        for event in &events {
            self.felt.see(event);
            self.stopwatch.see(event);
            if let Event::Note { text, .. } = event
                && !self.args.quiet
                && !text.starts_with(OFFSET_WORDS)
            {
                note(text);
            }
        }
        if let Some(report) = &mut self.report {
            report.add(&events);
        }
        self.journal.add(&events, Vec::new(), Vec::new());
    }

    fn take_all(&mut self) {
        for _ in 0..MOST_TAKEN {
            let Some((at, arrived)) = self.waiting.take() else {
                break;
            };
            match arrived {
                Arrived::Echo(bytes) => self.echo(&bytes, at),
                Arrived::About(bytes) => self.about(&bytes),
                Arrived::Touched(bytes) => self.frame(Frame::touched(&bytes), at),
                Arrived::Scanned(bytes) => self.frame(Frame::scanned(&bytes), at),
                Arrived::Oversized => self.frame(None, at),
            }
        }
    }

    fn echo(&mut self, bytes: &[u8], at: Instant) {
        let Some(echo) = Echo::read(bytes) else {
            return;
        };
        if echo.version == VERSION && echo.wearer == self.said.session {
            let said = Instant::from_micros(echo.said_us);
            self.gate.echoed(echo.session, said, echo.heard_us, at);
        }
    }

    /// A frame: judged, and felt or not.
    fn frame(&mut self, frame: Option<Frame>, arrived: Instant) {
        let Some(frame) = frame else {
            self.felt.damaged += 1;
            return;
        };
        match self.gate.judge(&frame.head, arrived) {
            Ok(at) => {
                self.felt
                    .arrived(&frame.head, at, arrived, self.gate.offset(arrived));
                self.stopwatch.arrived(&frame.head, at, arrived);
                self.feel(&frame, at, self.gate.likely_later(arrived));
            }
            Err(refusal) => self.refuse(refusal, arrived),
        }
    }

    fn refuse(&mut self, refusal: Refusal, now: Instant) {
        if let Refusal::Second(session) = refusal
            && !self.said.refused.contains(&session)
        {
            self.said.refused.push(session);
        }
        let is_news = matches!(
            refusal,
            Refusal::Version(_) | Refusal::Layout(_) | Refusal::Second(_) | Refusal::Jumped
        );
        let text = refusal.to_string();
        if is_news && self.felt.is_news(refusal.word()) {
            self.session
                .recorder()
                .note(now, format!("not felt: {text}"));
        }
        if !matches!(
            refusal,
            Refusal::Second(_) | Refusal::Order | Refusal::NoClock
        ) {
            self.said.trouble = text;
        }
    }

    fn feel(&mut self, frame: &Frame, at: Instant, later: Duration) {
        let held = match &frame.body {
            Body::Touched(contacts) => self.session.hold(at, later, contacts),
            Body::Scanned { module, counts } => {
                let owner = frame.head.session;
                let Some((_, shrunk)) = self.shrunk.as_mut().filter(|(of, _)| *of == owner) else {
                    self.ask(owner, at);
                    return;
                };
                let scan = ModuleScan {
                    module: *module,
                    // Its own time, on the robot's clock, as where it was read.
                    at: Instant::from_micros(frame.head.taken_us),
                    counts,
                    fresh: None,
                };
                match shrunk.push(&scan) {
                    Ok(Some((_, contacts))) => {
                        let contacts = contacts.to_vec();
                        shrunk.recorder().events.clear();
                        self.session.hold(at, later, &contacts)
                    }
                    Ok(None) => return,
                    Err(_) => {
                        self.felt.damaged += 1;
                        return;
                    }
                }
            }
        };
        match held {
            Ok(()) => {
                self.newest = Some(at);
                self.felt.held += 1;
            }
            Err(foreign) => {
                self.felt.damaged += 1;
                self.said.trouble = foreign.to_string();
            }
        }
    }

    /// Asks a publisher of scans for those that its reference was made of.
    fn ask(&mut self, owner: u64, now: Instant) {
        if self.asked == Some(owner) && !self.asks.take(now) {
            return;
        }
        self.asked = Some(owner);
        self.asks_now = true;
    }

    /// The reference of a publisher of scans: the same scans make the same one here.
    fn about(&mut self, bytes: &[u8]) {
        let expected = self.asked;
        let Some(about) = About::read(bytes).filter(|a| Some(a.session) == expected) else {
            return;
        };
        let wanted = self.setup.scene.value.reference_frames + 1;
        let modules = self.setup.sensor.value.modules.len();
        if about.version != VERSION || about.rest.len() < wanted as usize * modules {
            return;
        }
        let Ok(mut shrunk) = Shrunk::new(
            self.setup,
            self.args.on.seed,
            self.levels.clone(),
            Truth::Unknown,
        ) else {
            return;
        };
        for scan in &about.rest {
            let Some(Frame {
                head,
                body: Body::Scanned { module, counts },
                ..
            }) = Frame::scanned(scan)
            else {
                return;
            };
            let scan = ModuleScan {
                module,
                at: Instant::from_micros(head.taken_us),
                counts: &counts,
                fresh: None,
            };
            if shrunk.push(&scan).is_err() {
                return;
            }
        }
        shrunk.recorder().events.clear();
        self.shrunk = Some((about.session, shrunk));
    }
}
