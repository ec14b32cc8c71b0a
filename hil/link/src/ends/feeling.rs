//! The loop of a finger that feels frames: projection clock, guard and deadlines are here; nothing that a network does
//! reaches an output but a fresh reading.

use std::slice;
use std::sync::mpsc::SyncSender;
use std::time::Duration as Wait;

use palpate_buses::pacer::{RunClock, Watch};
use palpate_buses::signals::Signals;
use palpate_core::projector::Projector;
use palpate_core::skin::ModuleScan;
use palpate_core::units::{Duration, Instant};
use palpate_files::Setup;
use palpate_live::output::print_json;
use palpate_live::real::{Watched, beat, begin, keep, leave, priority};
use palpate_live::record::Journal;
use palpate_records::mcap::{decode, encoded};
use palpate_records::trace::Event;
use palpate_run::{Failure, HeldSession, Policy, Truth, Turn, Wish, header};

use super::heard::{Arrived, Heard, Waiting};
use super::report::Report;
use super::shrunk::Shrunk;
use crate::budget::Stopwatch;
use crate::cli::{DisplayArgs, after};
use crate::judge::{Bucket, Gate, Patience, Refusal};
use crate::message::{Body, Echo, Frame, VERSION, Wearer};
use crate::name::Name;
use crate::net::Net;
use crate::records::{Felt, OFFSET_WORDS, journal, layout_digest, session_of};

/// Messages that are taken in one turn at most: a flood must not keep the loop from its guard.
const MOST_TAKEN: usize = 64;
/// Time between two messages of a wearer.
const BEAT: Duration = Duration::from_millis(100);
/// Time between two of the first beats: until publisher and wearer have heard of each other nothing is felt.
const FIRST_BEATS: Duration = Duration::from_millis(20);

/// Time between two statements of the clocks' bounds in the record.
const STATED: Duration = Duration::from_millis(1000);

/// A wearer's finger: its options, name, setup and network.
#[derive(Clone, Copy)]
pub(super) struct Finger<'a> {
    pub(super) args: &'a DisplayArgs,
    pub(super) wearer: &'a Name,
    pub(super) setup: &'a Setup,
    pub(super) net: &'a Net,
    /// Real-time priority, as the bench wants it.
    pub(super) realtime: Option<bool>,
    /// The wires are cold, and are to be passed while nothing is felt.
    pub(super) is_cold: bool,
}

/// The loop of a finger that feels frames.
pub(super) struct Feeling<'a, D> {
    setup: &'a Setup,
    is_cold: bool,
    args: &'a DisplayArgs,
    realtime: Option<bool>,
    clock: RunClock,
    waiting: Waiting,
    /// Lines for people, who must not hold up the loop.
    says: SyncSender<String>,
    gate: Gate,
    session: HeldSession<D>,
    journal: Journal,
    said: Wearer,
    felt: Felt,
    stopwatch: Stopwatch,
    report: Option<Report>,
    /// Compression of the publisher's scans, with the publisher's session.
    shrunk: Option<(u64, Box<Shrunk>)>,
    /// The publisher whose reference was asked for.
    asked: Option<u64>,
    asks: Bucket,
    /// `true` to ask for the publisher's reference with the next word.
    asks_now: bool,
    next_beat: Instant,
    next_stated: Instant,
    /// The time of the newest reading that was felt.
    newest: Option<Instant>,
}

impl<'a, D: Watched> Feeling<'a, D> {
    /// The loop of a projector on outputs that are opened last: an error before is no death that a guardian sees.
    pub(super) fn new(
        finger: Finger<'a>,
        projector: Projector,
        outputs: impl FnOnce(&Projector) -> Result<(D, Policy), Failure>,
        (clock, waiting): (RunClock, Waiting),
        says: SyncSender<String>,
    ) -> Result<Self, Failure> {
        let Finger {
            args,
            wearer,
            setup,
            net,
            realtime,
            is_cold,
        } = finger;
        let seed = args.on.seed;
        let journal = journal(setup, seed, &projector, &args.record, args.force)?;
        let layout = layout_digest(&setup.sensor.value);
        let modules = setup.sensor.value.modules.len();
        let own = session_of(&net.session);
        let report = (args.html.as_deref())
            .map(|path| Report::begin(path, args.force, header(setup, seed, &projector)?))
            .transpose()?;
        let stopwatch = Stopwatch::new(setup, &projector)?;
        let (display, policy) = outputs(&projector)?;
        let mut session = HeldSession::held_on(projector, display, policy, Truth::Unknown)?;
        session.plan_passes(setup);
        Ok(Self {
            session,
            setup,
            is_cold,
            stopwatch,
            report,
            felt: Felt::new(&args.finger, wearer.as_str(), own, clock.epoch_ns()),
            gate: Gate::new(Patience::of_modules(VERSION, layout, modules)),
            said: Wearer {
                version: VERSION,
                session: own,
                ..Wearer::default()
            },
            args,
            realtime,
            clock,
            waiting,
            says,
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

    /// Feels until a signal, the end of its time, or a failure. The outputs go off whatever ended it.
    pub(super) fn until(mut self, signals: &Signals, heard: &Heard) -> Result<(), Failure> {
        let clock = self.clock;
        priority(self.realtime).inspect_err(|_| {
            // Nothing is on yet: the good-bye cannot fail in a way that matters more than this.
            let _ = self.session.display().part(Ok(()), true);
        })?;
        let mut next = begin(slice::from_mut(&mut self.session), clock)?;
        if self.is_cold {
            self.session.grant(Wish::HotPass, clock.now());
        }
        let end = self.args.seconds.map(after);
        let (mut stopped, mut watch) = (None, Watch::new());
        loop {
            let now = clock.now();
            if let Some(unseen) = watch.look(now)
                && !self
                    .session
                    .unseen(now, unseen.uncounted(), &unseen.to_string())
            {
                break;
            }
            if let Err(failure) = beat(&mut self.session, now) {
                self.session.set_failure(failure);
                break;
            }
            if end.is_some_and(|end| now >= end) {
                stopped.get_or_insert("its time is over".to_owned());
            }
            if let Some(signal) = signals.caught() {
                stopped = Some(format!("stopped by {signal}"));
            }
            if stopped.is_some() || self.journal.has_failed() {
                break;
            }
            assert!(
                !signals.wants_panic(),
                "a drill, by PALPATE_DRILL and SIGUSR1"
            );
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
        let end = leave(&mut self.session, clock);
        self.keep_passed();
        self.said.stopped = stopped.unwrap_or_else(|| match self.session.failure() {
            Some(failure) => failure.to_string(),
            None => "a record cannot be written".into(),
        });
        self.beat(end, heard);
        self.state_offset(end);
        self.tell();
        self.finish(end)
    }

    /// Keeps whether the wires were passed, where they were cold.
    fn keep_passed(&mut self) {
        let Some(passing) = self.session.projector().passing() else {
            return;
        };
        if let Err(failure) = keep(self.setup, passing.has_passed()) {
            self.session.set_failure(failure);
        }
    }

    /// Finishes records and report when the run is over.
    fn finish(mut self, end: Instant) -> Result<(), Failure> {
        let latency = self.stopwatch.finish();
        self.felt
            .finish(&self.gate, end, self.waiting.overflowed(), latency);
        self.felt.unit = self.session.display().unit();
        if !self.args.json && !self.args.quiet {
            self.say(&self.felt.line());
            self.say(&self.felt.latency().line());
        }
        // The failure that ended the run counts, before errors of its files.
        let ended = self.session.take_failure().map_or(Ok(()), Err);
        let written = self.journal.finish();
        if let Some(report) = self.report.take() {
            report.write(self.felt.latency(), self.session.recorder().driven, end)?;
        }
        if self.args.json {
            print_json(&self.felt)?;
        }
        ended.and(written)
    }

    /// Tells people something; a line that finds no room is left out.
    fn say(&self, text: &str) {
        let _ = self.says.try_send(text.to_owned());
    }

    /// States the bounds of the clocks in the record.
    fn state_offset(&mut self, now: Instant) {
        self.next_stated = now + STATED;
        if let Some((low, high)) = self.gate.offset(now) {
            let text = format!("{OFFSET_WORDS}{low} to {high} us");
            self.session.recorder().note(now, text);
        }
    }

    /// Sends the wearer's state.
    fn beat(&mut self, now: Instant, heard: &Heard) {
        self.said.said_us = self.clock.now().as_micros();
        self.said.feels = self.gate.feels(now).unwrap_or(0);
        if let Some(stop) = self
            .session
            .failure()
            .filter(|_| self.said.stopped.is_empty())
        {
            self.said.stopped = stop.to_string();
        }
        let step = if self.gate.offset(now).is_some() {
            BEAT
        } else {
            FIRST_BEATS
        };
        self.next_beat = now + step;
        if now >= self.next_stated {
            self.state_offset(now);
        }
        heard.voice.say(encoded(&mut self.said).bytes().to_vec());
        if std::mem::take(&mut self.asks_now) {
            heard.voice.ask();
        }
        // Refusals are told once.
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
            if let Event::Note(note) = event
                && !self.args.quiet
                && !note.text.starts_with(OFFSET_WORDS)
            {
                self.say(&note.text);
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
                Arrived::Reference(owner, shrunk) if self.asked == Some(owner) => {
                    self.shrunk = Some((owner, shrunk));
                }
                // Of a publisher that was not asked.
                Arrived::Reference(..) => {}
                Arrived::Touched(bytes) => self.frame(Frame::touched(&bytes), at),
                Arrived::Scanned(bytes) => self.frame(Frame::scanned(&bytes), at),
                Arrived::Oversized => self.frame(None, at),
            }
        }
    }

    fn echo(&mut self, bytes: &[u8], at: Instant) {
        let Some(echo) = decode::<Echo>(bytes) else {
            return;
        };
        if echo.version == VERSION && echo.wearer == self.said.session {
            let said = Instant::from_micros(echo.said_us);
            self.gate.echoed(echo.session, said, echo.heard_us, at);
        }
    }

    /// Takes a frame: judges it, and feels it or not.
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
}
