//! A run on a real bench: the same session, held to the wall clock, between SocketCAN and Linux I2C adapters.

mod bench;
mod ends;
mod link;

pub use bench::{refuse_latched, watch};

use std::path::PathBuf;

use palpate_buses::pacer::{Lateness, Pacer, RunClock};
use palpate_buses::signals::Signals;
use palpate_buses::sys::{forbid_core_dumps, lock_memory, set_fifo_priority};
use palpate_core::projector::Projector;
use palpate_core::units::{Duration, Instant};
use palpate_files::{BenchKind, Real, Setup};
use palpate_records::readings::Readings;
use palpate_records::trace::{Header, Ledger};
use palpate_run::effort::Effort;
use palpate_run::plan::differences;
use palpate_run::skin_end::Tap;
use palpate_run::{
    AskedLevel, CanPlayer, CanReport, EmulatedSkin, Failure, Input, Outcome, Pacing, Policy,
    Recorder, Rows, Session, Truth, Turn, attachments, build, dynamic_levels, finished, header,
    scene_levels, skin,
};

use crate::clock;
use crate::host::open_watch;
use crate::interfaces::reports;
use crate::output::{Outputs, note};
use crate::progress::Progress;
use crate::record::{About, Journal, Kind, Sink};
use crate::unit::remote::{RemoteUnit, UnitPlace};
use crate::watch::Watch;

use bench::{Interfaces, Live};
use ends::{Sensed, Watched};
use link::LinkEnd;

/// Real-time priority of the loop, below the guardian's.
const PRIORITY: u8 = 50;

/// What sees a run while it goes on.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Told {
    /// Standard error gets errors alone.
    pub quiet: bool,
    /// A live view, which notes would tear.
    pub watched: bool,
}

/// What the loop leaves behind.
struct Done<S, D> {
    session: Session<S, D>,
    lateness: Lateness,
    realtime: bool,
    not_recorded: u64,
    end: Instant,
}

/// What a run writes and says while it goes on.
#[derive(Clone, Copy, Debug)]
pub struct Wanted<'a> {
    /// Files that grow.
    pub files: &'a [(Kind, PathBuf)],
    /// What they may replace.
    pub outputs: Outputs<'a>,
    /// Who sees the run.
    pub told: Told,
}

/// Runs in real time: a scene's length on a real bench, where what touches the skin is up to the world, or a scene or
/// recording on the driver unit that the bench names.
///
/// # Errors
/// [`Failure`] for input that fits no loop, or a bench that cannot be opened or started.
pub fn run(
    setup: &Setup,
    input: &Input,
    seed: u64,
    wanted: Wanted<'_>,
) -> Result<Outcome, Failure> {
    // What lets an abort in the middle of a burst be noticed late; refused, it is noticed by the heartbeat.
    let _ = forbid_core_dumps();
    // A backtrace takes its time, and outputs are on while it is made: the place has to do.
    std::panic::set_hook(Box::new(|panic| note(&panic.to_string())));
    let signals = Signals::catch().map_err(|e| Failure::Device(format!("signals: {e}")))?;
    match UnitPlace::of(&setup.bench)? {
        None => wired(setup, input, seed, signals, wanted),
        Some(place) => on_unit(setup, input, seed, &place, signals, wanted),
    }
}

/// The buses of a real bench.
fn real_of(setup: &Setup) -> Result<&Real, Failure> {
    let bench = &setup.bench.value;
    bench
        .real
        .as_ref()
        .ok_or_else(|| Failure::Input(format!("bench `{}`: expected kind = \"real\"", bench.name)))
}

/// On boards of this computer.
fn wired(
    setup: &Setup,
    input: &Input,
    seed: u64,
    signals: Signals,
    wanted: Wanted<'_>,
) -> Result<Outcome, Failure> {
    if !matches!(input, Input::Scene) {
        let expected =
            "--replay, --stream: readings from elsewhere drive an emulated bench or a unit only";
        return Err(Failure::Input(expected.into()));
    }
    let real = real_of(setup)?;
    let run = Running::begin(setup, seed, signals, wanted)?;
    let layout = run.projector.layout();
    let clock = RunClock::start();
    // The guardian last.
    let can = Interfaces::open(real, layout, clock)?;
    let live = Live::open(&setup.bench.value, real, run.projector.guard().prescale())?;
    let skin = skin::source(setup, layout, Tap::new(can, run.keeps_can));
    run.until_end((skin, live), clock, scene_end(setup))
}

/// On a driver unit: the skin is the bench's own, emulated, or a recording.
fn on_unit(
    setup: &Setup,
    input: &Input,
    seed: u64,
    place: &UnitPlace,
    signals: Signals,
    wanted: Wanted<'_>,
) -> Result<Outcome, Failure> {
    refuse_stopped(place)?;
    let delay_ms = setup.bench.value.unit.as_ref().map_or(0, |u| u.delay_ms);
    let mut setup = setup.clone();
    let met = RemoteUnit::open(place, delay_ms, RunClock::start())?.ask(1)?;
    setup.unit = Some(met.0);
    let mut notes = differences(&setup)?;
    if !setup.scene.value.faults.is_empty() {
        notes
            .push("the scene's faults are left out: a unit's hardware is not emulated here".into());
    }
    if !wanted.told.quiet {
        notes.iter().for_each(|text| note(text));
    }
    let setup = &setup;
    let run = Running::begin(setup, seed, signals, wanted)?;
    let (layout, keeps_can) = (run.projector.layout(), run.keeps_can);
    let clock = RunClock::start();
    let open = || -> Result<LinkEnd, Failure> {
        let mut unit = RemoteUnit::open(place, delay_ms, clock)?;
        unit.connect()?;
        Ok(LinkEnd(unit))
    };
    let after = |last: Instant| last + Duration::from_millis(100);
    match input {
        Input::Scene if setup.bench.value.kind == BenchKind::Real => {
            let can = Interfaces::open(real_of(setup)?, layout, clock)?;
            let skin = skin::source(setup, layout, Tap::new(can, keeps_can));
            run.until_end((skin, open()?), clock, scene_end(setup))
        }
        Input::Scene => {
            let skin = EmulatedSkin::scene(setup, seed)?;
            run.until_end((skin, open()?), clock, scene_end(setup))
        }
        Input::Rows(sources) => {
            let skin = Rows::new(sources, &setup.sensor.value, layout)?;
            let last = sources.iter().map(|s| s.span_us()).max().unwrap_or(0);
            let end = after(Instant::from_micros(last));
            run.until_end((skin, open()?), clock, end)
        }
        Input::Frames(frames) => {
            let player = CanPlayer::new(frames.frames()?);
            let skin = skin::source(setup, layout, Tap::new(player, keeps_can));
            run.until_end((skin, open()?), clock, after(frames.end()))
        }
        Input::Stream(_) => Err(Failure::Input(
            "--stream: expected --replay or the bench's own skin with a unit".into(),
        )),
    }
}

/// Refuses a unit while a stop of a run on it is kept.
fn refuse_stopped(place: &UnitPlace) -> Result<(), Failure> {
    match place.latch().read() {
        None => Ok(()),
        Some(held) => Err(Failure::Guard(format!(
            "unit {}: stopped earlier: {}. Look at the wearer, then clear the stop with `hil off --unlatch --unit {} --key FILE`",
            place.name, held.cause, place.name
        ))),
    }
}

/// When a scene ends.
fn scene_end(setup: &Setup) -> Instant {
    Instant::from_micros((setup.scene.value.length_s * 1e6).round() as u64)
}

/// A run that is about to begin: its loop and its records.
struct Running<'a> {
    setup: &'a Setup,
    projector: Projector,
    header: Header,
    signals: Signals,
    journal: Journal,
    taxels: Option<Readings>,
    keeps_can: bool,
    told: Told,
    started: std::time::Duration,
}

impl<'a> Running<'a> {
    fn begin(
        setup: &'a Setup,
        seed: u64,
        signals: Signals,
        wanted: Wanted<'_>,
    ) -> Result<Self, Failure> {
        let started = clock::elapsed();
        let scene = &setup.scene.value;
        let levels = if scene.touches.is_empty() {
            dynamic_levels(&scene.compression)
        } else {
            scene_levels(setup, seed)?
        };
        let projector = build(setup, seed, levels)?;
        let (header, attached) = (header(setup, seed, &projector)?, attachments(setup));
        let writes = |kind: Kind| wanted.files.iter().any(|(other, _)| *other == kind);
        let decoded = || Readings::whole(projector.layout(), scene.drives);
        let taxels = writes(Kind::Mcap).then(decoded);
        let modules = taxels.as_ref().map_or(&[][..], Readings::modules);
        let about = About::Run(&header, modules, &attached);
        let sinks = Sink::create_all(wanted.files, &about, wanted.outputs)?;
        let journal = Journal::start(sinks, !wanted.told.quiet && !wanted.told.watched)?;
        Ok(Self {
            setup,
            keeps_can: writes(Kind::Can) || writes(Kind::Mcap),
            projector,
            header,
            signals,
            journal,
            taxels,
            told: wanted.told,
            started,
        })
    }

    /// The loop on a thread of its own, for `length` or until something ends it.
    fn until_end<S: Sensed + Send, D: Watched + Send>(
        self,
        ends: (S, D),
        run_clock: RunClock,
        length: Instant,
    ) -> Result<Outcome, Failure> {
        let setup = self.setup;
        let watch = match self.told.watched {
            true => open_watch(&self.header, self.projector.layout(), length, false)?,
            false => None,
        };
        let real = setup.bench.value.real.as_ref();
        let turns = Turns {
            can: real.map_or(&[], |real| &real.can),
            realtime: real.and_then(|real| real.realtime),
            clock: run_clock,
            signals: self.signals,
            length,
            drives: setup.scene.value.drives,
            truth: match setup.bench.value.kind {
                BenchKind::Real => Truth::Unknown,
                BenchKind::Emulated => Truth::of(setup),
            },
            taxels: self.taxels,
            journal: self.journal,
            watch,
            progress: Progress::of_part("run"),
        };
        let projector = self.projector;
        let done = std::thread::scope(|scope| {
            let thread = std::thread::Builder::new()
                .name("loop".into())
                .spawn_scoped(scope, || turns.drive(projector, ends));
            let thread = thread.map_err(|e| Failure::Device(format!("the loop's thread: {e}")))?;
            // A panic has dropped the guardian's socket, or a unit hears no more: everything is off or about to be.
            let panicked = |_| {
                let text = "the loop panicked; the guardian or the unit switches everything off";
                Failure::Device(text.into())
            };
            thread.join().map_err(panicked)?
        })?;
        let mut outcome = outcome(setup, self.header, done);
        outcome.summary.wall_s = clock::elapsed().saturating_sub(self.started).as_secs_f64();
        Ok(outcome)
    }
}

/// What paces a session on hardware and watches over it.
struct Turns<'a> {
    /// The bench's CAN interfaces.
    can: &'a [String],
    /// Whether real-time priority is insisted on, or done without.
    realtime: Option<bool>,
    clock: RunClock,
    signals: Signals,
    length: Instant,
    drives: usize,
    truth: Truth,
    /// Where decoded taxels are recorded.
    taxels: Option<Readings>,
    journal: Journal,
    watch: Option<Watch>,
    progress: Progress,
}

impl Turns<'_> {
    /// The loop on its own thread, until the scene's end, a signal, or a failure.
    fn drive<S: Sensed, D: Watched>(
        mut self,
        projector: Projector,
        (skin, mut display): (S, D),
    ) -> Result<Done<S, D>, Failure> {
        let truth = std::mem::take(&mut self.truth);
        let mut recorder = Recorder::new(truth, projector.layout());
        recorder.counts = self.watch.is_some().then(Vec::new);
        recorder.readings = Some(Readings::sampled(projector.layout(), self.drives));
        recorder.taxels = self.taxels.take();
        let realtime = match self.realtime {
            Some(false) => false,
            None => take_priority().is_ok(),
            Some(true) => match take_priority() {
                Ok(()) => true,
                Err(refused) => {
                    // Nothing is on yet: the good-bye cannot fail in a way that matters more than this.
                    let _ = display.part(Ok(()), true);
                    return Err(refused);
                }
            },
        };
        for line in display.found().lines() {
            recorder.note(Instant::ZERO, format!("{line}; switched off"));
        }
        let run_clock = self.clock;
        let ends = (skin, display);
        let mut session = Session::new(
            projector,
            ends,
            Policy::REAL,
            recorder,
            Some(clock::elapsed),
        );
        let ready = match session.start(run_clock.now()) {
            Ok(ready) => ready,
            Err(error) => {
                let display = session.display();
                let cause = display.explain(&error);
                display.abandon(&cause);
                return Err(Failure::Device(cause));
            }
        };
        session.skin().begin();
        let mut pacer = Pacer::new(run_clock);
        let mut now = pacer.wait(ready);
        let (begun, length) = (now, self.length.as_micros() as f64);
        let end = Instant::from_micros(self.length.as_micros().saturating_add(now.as_micros()));
        while now < end && self.goes_on(&mut session, now) {
            self.progress
                .part(now.since(begun).as_micros() as f64 / length);
            match session.turn(now)? {
                Turn::Next(next) => {
                    if self.is_stopped(&mut session, now) {
                        break;
                    }
                    now = pacer.wait(next);
                }
                Turn::Last => break,
            }
        }
        let end = run_clock.now();
        self.part(&mut session, end);
        self.tell(&mut session);
        let not_recorded = self.journal.dropped();
        if let Err(error) = self.journal.finish() {
            session.set_failure(error);
        }
        drop(self.watch);
        Ok(Done {
            session,
            lateness: pacer.lateness().clone(),
            realtime,
            not_recorded,
            end,
        })
    }

    /// Before a turn: the display's heartbeat, signals, records.
    fn goes_on<S: Sensed, D: Watched>(
        &mut self,
        session: &mut Session<S, D>,
        now: Instant,
    ) -> bool {
        if let Err(failure) = session.display().beat(now) {
            session.set_failure(failure);
            return false;
        }
        if let Some(signal) = self.signals.caught() {
            session.recorder().note(now, format!("stopped by {signal}"));
            return false;
        }
        assert!(
            !self.signals.wants_panic(),
            "a drill, by PALPATE_DRILL and SIGUSR1"
        );
        while let Some(note) = session.skin().note() {
            session.recorder().note(note.at, note.text);
        }
        self.tell(session);
        !self.journal.has_failed()
    }

    /// Hands what is new to the records.
    fn tell<S: Sensed, D: Watched>(&mut self, session: &mut Session<S, D>) {
        let frames = session.skin().take_frames();
        let recorder = session.recorder();
        let taxels = recorder.taxels.as_mut().map(Readings::take_frames);
        self.journal
            .tell(&recorder.events, frames, taxels.unwrap_or_default());
    }

    /// Shows a turn; whether the person in front of it wants no more.
    fn is_stopped<S: Sensed, D: Watched>(
        &mut self,
        session: &mut Session<S, D>,
        now: Instant,
    ) -> bool {
        let Some(watch) = &mut self.watch else {
            return false;
        };
        let (skin, recorder) = session.seen();
        let counts = recorder.counts.as_deref().unwrap_or_default();
        let tallies = skin.tallies();
        let buses = || {
            let all = reports(self.can, &tallies);
            all.iter().map(CanReport::words).collect()
        };
        let stopped = watch.turn(0, now, &recorder.events, counts, buses);
        if stopped {
            let note = "stopped by the person who watched".into();
            session.recorder().note(now, note);
        }
        stopped
    }

    /// Everything off, and the display's leave. The screen may take its time; the outputs do not wait for it.
    fn part<S: Sensed, D: Watched>(&self, session: &mut Session<S, D>, end: Instant) {
        let off = session.switch_off(end);
        let failed = session.failure().is_some();
        let display = session.display();
        let off = off.map_err(|error| display.explain(&error));
        if let Err(cause) = display.part(off, failed) {
            let text = format!("not everything is known to be off: {cause}");
            session.recorder().note(end, text);
            session.set_failure(Failure::Device(cause));
        }
    }
}

/// Real-time priority for this thread, memory that is never paged out for the program.
///
/// # Errors
/// [`Failure::Device`] where the system does not allow it.
pub fn take_priority() -> Result<(), Failure> {
    let locked = lock_memory().and_then(|()| set_fifo_priority(PRIORITY));
    locked.map_err(|errno| {
        Failure::Device(format!(
            "real-time priority: {}; allow it with `setcap cap_sys_nice,cap_ipc_lock=ep` on the program, or leave `realtime` out of the bench",
            errno.desc()
        ))
    })
}

/// How late turns were.
fn pacing(lateness: &Lateness, realtime: bool) -> Pacing {
    Pacing {
        turns: lateness.turns(),
        median_us: lateness.quantile_us(0.5),
        p99_us: lateness.quantile_us(0.99),
        worst_us: lateness.worst_us(),
        realtime,
    }
}

/// The run on paper.
fn outcome<S: Sensed, D: Watched>(setup: &Setup, header: Header, mut done: Done<S, D>) -> Outcome {
    let session = &mut done.session;
    let costs = session.take_costs();
    let failure = session.take_failure();
    let mut effort = Effort::of(&costs, session.traffic());
    let ledger = Ledger {
        length_us: done.end.as_micros(),
        ..Ledger::default()
    };
    let (trace, mut summary) = finished(session, header, ledger, &costs, &setup.bench.value);
    let (_, projector, recorder) = session.all();
    effort.finish(projector, recorder);
    summary.felt.asked = AskedLevel::of(&setup.scene.value, projector);
    let readings = recorder.readings.take();
    summary.pacing = Some(pacing(&done.lateness, done.realtime));
    let names = setup.bench.value.real.as_ref().map(|real| &*real.can);
    let tallies = session.skin().tallies();
    summary.unit = session.display().unit();
    summary.can = reports(names.unwrap_or_default(), &tallies);
    summary.frames_not_recorded = done.not_recorded;
    Outcome {
        // Nothing measures a real finger.
        warmth: Vec::new(),
        readings,
        trace,
        summary,
        frame_us: costs.iter().map(|c| c.us).collect(),
        effort,
        can: Vec::new(),
        i2c: Vec::new(),
        notes: Vec::new(),
        displays: Vec::new(),
        failure,
    }
    .concluded(setup, false)
}
