//! `palpate-link skin`: publishes a robot's skin, in real time, and answers its wearers.

use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration as Wait;

use palpate_buses::pacer::RunClock;
use palpate_buses::signals::Signals;
use palpate_core::contact::Levels;
use palpate_core::skin::ModuleScan;
use palpate_core::units::{Duration, Instant};
use palpate_files::{BenchKind, Setup};
use palpate_live::interfaces::reports;
use palpate_live::output::{note, print_json};
use palpate_live::real::Sensed;
use palpate_live::record::Journal;
use palpate_records::mcap::proto::Message;
use palpate_records::trace::{Event, event};
use palpate_run::{CanReport, Failure, Policy, Supervisor, Truth};
use serde::Serialize;
use zenoh::pubsub::Publisher;
use zenoh::{Session, Wait as _};

use super::answers::{Answers, SECOND, Wearers};
use super::bent::Bent;
use super::shrunk::{Shrunk, levels};
use super::skins::open;
use crate::cli::{Kind, SkinArgs, after};
use crate::judge::Head;
use crate::message::{self, About, Body, Frame, Scanned, Touched, VERSION};
use crate::name::FingerName;
use crate::net::{self, Mode, Net, zenoh};
use crate::records::{journal, layout_digest, session_of};

/// Time between two looks at the skin.
const TURN: Duration = Duration::from_millis(1);

/// Report of a run of this end.
#[derive(Debug, Default, Serialize)]
struct Sent {
    finger: String,
    session: String,
    frames: u64,
    bytes: u64,
    wearers: Vec<String>,
    stops: Vec<String>,
    refused_by: Vec<String>,
    /// Reports of the boards' interfaces.
    can: Vec<CanReport>,
    /// Start of the clock of the frames, CLOCK_MONOTONIC of this machine, nanoseconds.
    epoch_ns: i64,
}

/// Runs it.
///
/// # Errors
/// [`Failure`] with its exit status.
pub fn run(args: &SkinArgs) -> Result<(), Failure> {
    let setup = args.setup()?;
    if setup.scene.value.texture.is_some() {
        note("the scene's texture stays here: contacts and scans carry none");
    }
    let signals = Signals::catch().map_err(|e| Failure::Device(e.to_string()))?;
    let net = net::open(&args.at.at(), Mode::Peer, &signals)?;
    may_publish(&net, args)?;
    alone(&net, args)?;
    let again = args.at.is_twice(args.twice);
    let again = again.then(|| net::open_beside(&args.at.at())).flatten();
    let bent = args
        .glove
        .as_ref()
        .map(|wearer| Bent::begin(&net, &args.finger, wearer, &setup));
    let bent = bent.transpose()?;
    let hands = bent.as_ref().map(|bent| bent.hands().to_vec());
    let publishing = Publishing {
        args,
        setup: &setup,
        levels: levels(&setup, args.on.seed)?,
        signals,
        net: &net,
        again: again.as_ref(),
        bent,
    };
    open(&setup, args, hands.as_deref(), |skin, clock, end| {
        publishing.publish(skin, clock, end)
    })
}

/// Asks the holders of an access list whether this machine may publish the finger: zenoh itself drops in silence.
fn may_publish(net: &Net, args: &SkinArgs) -> Result<(), Failure> {
    let (Some(access), Some(name)) = (&net.access, &net.name) else {
        return Ok(());
    };
    let finger = args.finger.to_string();
    let refused = |by: &str| {
        Failure::Input(format!(
            "{finger}: `{name}` may not publish this finger, says the access list of {by}; a line `publishes = [\"{finger}\"]` there would allow it"
        ))
    };
    if !access.may_publish(name, &finger) {
        return Err(refused("this machine"));
    }
    let key = format!("{}/may/{finger}", crate::name::ROOT);
    let asked = net
        .session
        .get(key)
        .payload(name.clone())
        .timeout(Wait::from_millis(700))
        .wait();
    let Ok(answers) = asked else { return Ok(()) };
    for sample in net::samples(answers) {
        let answer = sample.payload().try_to_string().unwrap_or_default();
        if let Some(by) = answer.strip_prefix("no ") {
            return Err(refused(by));
        }
    }
    Ok(())
}

/// Refuses to be the second publisher of a finger.
fn alone(net: &Net, args: &SkinArgs) -> Result<(), Failure> {
    let key = args.finger.skin_alive("*");
    let asked = net
        .session
        .liveliness()
        .get(key)
        .timeout(Wait::from_millis(700))
        .wait();
    let Ok(answers) = asked else { return Ok(()) };
    let Some(sample) = net::samples(answers).next() else {
        return Ok(());
    };
    let key = sample.key_expr().as_str();
    let other = key.rsplit('/').next().unwrap_or_default();
    // The first one is told too, as far as it can be reached.
    let told = net.session.get(args.finger.about()).payload(SECOND);
    let told = told.timeout(Wait::from_millis(500)).wait();
    drop(told.map(|answers| answers.recv()));
    Err(Failure::Input(format!(
        "{}: expected a finger that is not published, found publisher {other}; stop it first, or choose another name",
        args.finger
    )))
}

/// A skin that is about to be published.
struct Publishing<'a> {
    args: &'a SkinArgs,
    setup: &'a Setup,
    levels: Levels,
    signals: Signals,
    net: &'a Net,
    again: Option<&'a Session>,
    bent: Option<Bent>,
}

/// State of a publisher while it runs.
struct Turns<'a> {
    of: Publishing<'a>,
    clock: RunClock,
    publisher: Publisher<'static>,
    /// Publisher of the same frames over a second connection.
    again: Option<Publisher<'static>>,
    /// Contacts, whatever it publishes: its last word is one.
    farewell: Publisher<'static>,
    shrunk: Shrunk,
    head: Head,
    message: Message,
    sent: Sent,
    /// The scans of the reference, for wearers that compress.
    rest: Arc<Mutex<About>>,
    resting: Vec<u32>,
    /// Tells boards that fall silent to send.
    supervisor: Supervisor,
}

impl Publishing<'_> {
    /// Publishes this skin until `end` at the latest. The skin's own time is the clock's.
    fn publish(self, skin: &mut dyn Sensed, clock: RunClock, end: Instant) -> Result<(), Failure> {
        let (args, net) = (self.args, self.net);
        let is_emulated = self.setup.bench.value.kind == BenchKind::Emulated;
        let truth = match (&self.bent, args.replay.is_empty() && is_emulated) {
            (Some(bent), _) => bent.truth(self.setup.scene.value.drives),
            (None, true) => Truth::of_scene(self.setup),
            (None, false) => Truth::Unknown,
        };
        let shrunk = Shrunk::new(self.setup, args.on.seed, self.levels.clone(), truth)?;
        let session = session_of(&net.session);
        let layout = layout_digest(&self.setup.sensor.value);
        let seed = args.on.seed;
        let journal = journal(
            self.setup,
            seed,
            shrunk.projector(),
            &args.record,
            args.force,
        )?;
        let touched = message::encoding::<Touched>();
        let (key, encoding) = match args.send {
            Kind::Contacts => (args.finger.contacts(), touched.clone()),
            Kind::Scans => (args.finger.scans(), message::encoding::<Scanned<'_>>()),
        };
        let again = self.again;
        let again = again.map(|s| net::frames(s, FingerName::again(&key), &encoding));
        let again = again.transpose()?;
        let publisher = net::frames(&net.session, key, &encoding)?;
        let farewell = net::frames(&net.session, args.finger.contacts(), &touched);
        let about = About {
            version: VERSION,
            session,
            layout,
            layout_name: self.setup.sensor.value.name.clone(),
            scene: self.setup.scene.value.name.clone(),
            kind: args.send.word().into(),
            rest: Vec::new(),
        };
        let answers = Answers::begin(net, &args.finger, clock, about)?;
        if !args.quiet {
            let (finger, word) = (&args.finger, args.send.word());
            note(&format!("publisher {session:016x} of {finger}: {word}"));
        }
        let turns = Turns {
            resting: vec![0; shrunk.projector().layout().modules().len()],
            publisher,
            again,
            farewell: farewell?,
            shrunk,
            head: Head {
                version: VERSION,
                session,
                sequence: 0,
                sent_us: 0,
                taken_us: 0,
                layout,
            },
            message: Message::default(),
            sent: Sent {
                finger: args.finger.to_string(),
                session: format!("{session:016x}"),
                epoch_ns: clock.epoch_ns(),
                ..Sent::default()
            },
            rest: Arc::clone(&answers.about),
            clock,
            supervisor: Supervisor::new(Policy::REAL.give_up),
            of: self,
        };
        turns.until(skin, end, journal, &answers.wearers)
    }
}

impl Turns<'_> {
    fn until(
        mut self,
        skin: &mut dyn Sensed,
        end: Instant,
        mut journal: Journal,
        wearers: &Mutex<Wearers>,
    ) -> Result<(), Failure> {
        let clock = self.clock;
        let end = self.of.args.seconds.map_or(end, after);
        let mut ended = Ok(());
        skin.begin();
        loop {
            let now = clock.now();
            if now >= end || self.of.signals.caught().is_some() || journal.has_failed() {
                break;
            }
            if self.of.net.session.is_closed() {
                ended = Err(Failure::Device("the network is closed to this end".into()));
                break;
            }
            self.bend(now);
            skin.advance_to(now);
            let mut wrong = None;
            let read = skin.scans(now, &mut |scan| {
                if let Err(error) = self.take(scan) {
                    wrong.get_or_insert(error);
                }
            });
            read.map_err(|e| Failure::Device(format!("skin: {e}")))?;
            if let Some(error) = wrong {
                ended = Err(error);
                break;
            }
            self.look_after(skin, now);
            let events = std::mem::take(&mut self.shrunk.recorder().events);
            journal.add(&events, skin.take_frames(), Vec::new());
            if let Err(refused) = self.look(wearers, now) {
                ended = Err(refused);
                break;
            }
            clock.sleep_until(now + TURN);
        }
        if ended.is_ok() {
            self.let_go();
        }
        let mut wearers = wearers.lock().unwrap_or_else(PoisonError::into_inner);
        self.sent.wearers = wearers.known.keys().cloned().collect();
        self.sent.stops = std::mem::take(&mut wearers.stops);
        drop(wearers);
        let real = self.of.setup.bench.value.real.as_ref();
        self.sent.can = reports(real.map_or(&[], |real| &real.can), &skin.tallies());
        journal.finish()?;
        if self.of.args.json {
            print_json(&self.sent)?;
        }
        ended
    }

    /// Bends the emulated hand as a glove says.
    fn bend(&mut self, now: Instant) {
        let Some(bent) = &mut self.of.bent else {
            return;
        };
        if let Some(text) = bent.turn(now, self.shrunk.recorder()) {
            if !self.of.args.quiet {
                note(&text);
            }
            self.shrunk.recorder().note(now, text);
        }
    }

    /// Sends a start command to silent boards, and reports the events of each bus.
    fn look_after(&mut self, skin: &mut dyn Sensed, now: Instant) {
        let mut events = Vec::new();
        while let Some(note) = skin.note() {
            events.push(Event::note(note.at, note.text));
        }
        self.supervisor
            .restart_boards(now, skin, self.shrunk.projector(), &mut events);
        if !self.of.args.quiet {
            let notes = event::each(&events);
            notes.for_each(|told: &event::Note| note(&told.text));
        }
        self.shrunk.recorder().events.extend(events);
    }

    /// Sends the last frame: nothing is touched any more. Wearers let go, where silence stops them.
    fn let_go(&mut self) {
        self.head.sequence += 1;
        self.head.sent_us = self.clock.now().as_micros();
        self.head.taken_us = self.head.sent_us;
        let frame = Frame {
            head: self.head,
            body: Body::Touched(Vec::new()),
            truth: None,
            flexed: 0,
        };
        frame.write(&mut self.message);
        // A wearer who does not get it finds the silence.
        drop(self.farewell.put(self.message.bytes()).wait());
    }

    /// Tells the news of wearers, and fails once one refuses this publisher.
    fn look(&mut self, wearers: &Mutex<Wearers>, now: Instant) -> Result<(), Failure> {
        let mut wearers = wearers.lock().unwrap_or_else(PoisonError::into_inner);
        wearers.look(now.as_micros());
        for text in wearers.news.drain(..) {
            self.shrunk.recorder().note(now, text.clone());
            if !self.of.args.quiet {
                note(&text);
            }
        }
        let refused_by = std::mem::take(&mut wearers.refused_by);
        match refused_by.first() {
            None => Ok(()),
            Some(wearer) => {
                self.sent.refused_by.clone_from(&refused_by);
                Err(Failure::Input(format!(
                    "{}: refused by wearer {wearer}, who feels another publisher of this finger",
                    self.of.args.finger
                )))
            }
        }
    }

    /// Takes a scan and sends the frame that it makes.
    fn take(&mut self, scan: &ModuleScan<'_>) -> Result<(), Failure> {
        let wrong = |e: palpate_core::skin::ScanError| Failure::Device(format!("skin: {e}"));
        let made = self.shrunk.push(scan).map_err(wrong)?;
        let made = made.map(|(at, contacts)| (at, contacts.to_vec()));
        let truth = self
            .shrunk
            .recorder()
            .truth_at(scan.at)
            .map(|(place, force_n)| message::Truth {
                at: [f64::from(place.x), f64::from(place.y)],
                force_n,
            });
        let (at, body) = match (self.of.args.send, made) {
            (Kind::Contacts, None) => return Ok(()),
            (Kind::Contacts, Some((at, contacts))) => (at, Body::Touched(contacts)),
            (Kind::Scans, _) => {
                let body = Body::Scanned {
                    module: scan.module,
                    counts: scan.counts.to_vec(),
                };
                (scan.at, body)
            }
        };
        self.head.sequence += 1;
        self.head.taken_us = at.as_micros();
        self.head.sent_us = self.clock.now().as_micros();
        let frame = Frame {
            head: self.head,
            body,
            truth,
            flexed: self.of.bent.as_ref().map_or(0, Bent::flexed),
        };
        frame.write(&mut self.message);
        self.keep_rest(usize::from(scan.module));
        let bytes = self.message.bytes();
        self.sent.frames += 1;
        self.sent.bytes += bytes.len() as u64;
        self.publisher.put(bytes).wait().map_err(zenoh)?;
        if let Some(again) = &self.again {
            // The first connection carries frames that the second one does not.
            drop(again.put(bytes).wait());
        }
        Ok(())
    }

    /// Keeps the first scans, which make the reference: a wearer that compresses needs the same ones.
    fn keep_rest(&mut self, module: usize) {
        let most = self.of.setup.scene.value.reference_frames + 1;
        let count = &mut self.resting[module];
        if self.of.args.send == Kind::Scans && *count < most {
            *count += 1;
            let mut about = self.rest.lock().unwrap_or_else(PoisonError::into_inner);
            about.rest.push(self.message.bytes().to_vec());
        }
    }
}
