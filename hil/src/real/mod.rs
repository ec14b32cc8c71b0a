//! A run on a real bench: the same session, held to the wall clock, between SocketCAN and Linux I2C adapters.

mod bench;
mod hand;
mod loops;
mod records;
mod warden;

pub use bench::watch;

use std::path::PathBuf;

use palpate_buses::pacer::{Lateness, Pacer};
use palpate_buses::signals::Signals;
use palpate_buses::sys::{forbid_core_dumps, lock_memory, set_fifo_priority};
use palpate_core::contact::Levels;
use palpate_core::projector::Projector;
use palpate_core::skin::CanSkin;
use palpate_core::units::Instant;
use palpate_files::{Real, Setup};
use palpate_records::readings::Readings;
use palpate_records::trace::{Header, Ledger};
use palpate_run::display_end::DisplayEnd;
use palpate_run::effort::Effort;
use palpate_run::skin_end::{SkinEnd, Tap};
use palpate_run::{
    AskedLevel, CanReport, Failure, Outcome, Pacing, Policy, Recorder, Session, Truth, Turn,
    attachments, build, dynamic_levels, finished, header, scene_levels, skin,
};

use crate::clock;
use crate::host::open_watch;
use crate::output::{Outputs, note};
use crate::progress::Progress;
use crate::record::{About, Journal, Kind, Sink};
use crate::watch::Watch;

use bench::{Interfaces, Live};

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

/// A session on hardware.
type RealSession<D = Live> = Session<CanSkin<Tap<Interfaces>>, D>;

/// What a loop leaves behind.
struct Done<D = Live> {
    session: RealSession<D>,
    lateness: Lateness,
    realtime: bool,
    not_recorded: u64,
    end: Instant,
}

/// Runs a scene's length on a real bench: what touches the skin is up to the world. `files` grow while it
/// runs; unless `quiet`, what happens to the bench goes to standard error.
///
/// # Errors
/// [`Failure`] for input that fits no loop, or a bench that cannot be opened or started.
pub fn run(
    setup: &Setup,
    seed: u64,
    (files, outputs): (&[(Kind, PathBuf)], Outputs<'_>),
    told: Told,
) -> Result<Outcome, Failure> {
    let started = clock::elapsed();
    let bench = &setup.bench.value;
    let Some(real) = &bench.real else {
        return Err(Failure::Input(format!(
            "bench `{}`: expected kind = \"real\"",
            bench.name
        )));
    };
    let run = match setup.fingers.is_empty() {
        true => alone,
        false => hand::run,
    };
    let mut outcome = run((setup, real), seed, (files, outputs), told)?;
    outcome.summary.wall_s = clock::elapsed().saturating_sub(started).as_secs_f64();
    Ok(outcome)
}

/// Makes the process ready for wires that a person wears; the signals that end it.
fn prepare() -> Result<Signals, Failure> {
    // An abort in the middle of a burst must be noticed at once; refused, it is noticed by the heartbeat.
    let _ = forbid_core_dumps();
    // A backtrace takes its time, and outputs are on while it is made: the place has to do.
    std::panic::set_hook(Box::new(|panic| note(&panic.to_string())));
    Signals::catch().map_err(|e| Failure::Device(format!("signals: {e}")))
}

/// The intensity levels of a scene's own touches; without touches they are found frame by frame.
fn levels(setup: &Setup, seed: u64) -> Result<Levels, Failure> {
    let scene = &setup.scene.value;
    match scene.touches.is_empty() {
        true => Ok(dynamic_levels(&scene.compression)),
        false => scene_levels(setup, seed),
    }
}

/// How long a scene is.
fn length(setup: &Setup) -> Instant {
    Instant::from_micros((setup.scene.value.length_s * 1e6).round() as u64)
}

/// A run of the only display of a bench.
fn alone(
    (setup, real): (&Setup, &Real),
    seed: u64,
    (files, outputs): (&[(Kind, PathBuf)], Outputs<'_>),
    told: Told,
) -> Result<Outcome, Failure> {
    let signals = prepare()?;
    let (scene, bench) = (&setup.scene.value, &setup.bench.value);
    let projector = build(setup, seed, levels(setup, seed)?)?;
    let (header, attached) = (header(setup, seed, &projector)?, attachments(setup));
    let writes = |wanted: Kind| files.iter().any(|(kind, _)| *kind == wanted);
    let decoded = || Readings::whole(projector.layout(), scene.drives);
    let taxels = writes(Kind::Mcap).then(decoded);
    let modules = taxels.as_ref().map_or(&[][..], Readings::modules);
    let about = About::Run(&header, modules, &attached);
    let sinks = Sink::create_all(files, &about, outputs)?;
    let journal = Journal::start(sinks, !told.quiet && !told.watched)?;
    let keeps_can = writes(Kind::Can) || writes(Kind::Mcap);
    let (live, can) = Live::open(
        bench,
        real,
        projector.layout(),
        projector.guard().prescale(),
    )?;
    let length = length(setup);
    let watch = match told.watched {
        true => open_watch(&header, projector.layout(), length, false)?,
        false => None,
    };
    let skin = skin::source(setup, projector.layout(), Tap::new(can, keeps_can));
    let turns = Turns {
        real,
        signals,
        length,
        drives: scene.drives,
        taxels,
        journal,
        watch,
        progress: Progress::of_part("run"),
    };
    let done = std::thread::scope(|scope| {
        let drive = || turns.drive(projector, skin, live);
        let thread = std::thread::Builder::new()
            .name("loop".into())
            .spawn_scoped(scope, drive);
        let thread = thread.map_err(|e| Failure::Device(format!("the loop's thread: {e}")))?;
        // A panic has dropped the guardian's socket: everything is off or about to be.
        let panicked =
            |_| Failure::Device("the loop panicked; the guardian switches everything off".into());
        thread.join().map_err(panicked)?
    })?;
    Ok(outcome(setup, header, done))
}

/// What paces a session on hardware and watches over it.
struct Turns<'a> {
    real: &'a Real,
    signals: Signals,
    length: Instant,
    drives: usize,
    /// Where decoded taxels are recorded.
    taxels: Option<Readings>,
    journal: Journal,
    watch: Option<Watch>,
    progress: Progress,
}

impl Turns<'_> {
    /// The loop on its own thread, until the scene's end, a signal, or a failure.
    fn drive(
        mut self,
        projector: Projector,
        skin: CanSkin<Tap<Interfaces>>,
        mut live: Live,
    ) -> Result<Done, Failure> {
        let mut recorder = Recorder::new(Truth::Unknown, projector.layout());
        recorder.counts = self.watch.is_some().then(Vec::new);
        recorder.readings = Some(Readings::sampled(projector.layout(), self.drives));
        recorder.taxels = self.taxels.take();
        let realtime = match self.real.realtime {
            Some(false) => false,
            None => take_priority().is_ok(),
            Some(true) => match take_priority() {
                Ok(()) => true,
                Err(refused) => {
                    // Nothing is on yet: the good-bye cannot fail in a way that matters more than this.
                    let _ = live.watchman.guardian.end();
                    return Err(refused);
                }
            },
        };
        for line in live.found.lines() {
            recorder.note(Instant::ZERO, format!("{line}; switched off"));
        }
        let run_clock = live.clock;
        let ends = (skin, live);
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
                let live = session.display();
                let cause = live.explain(&error);
                live.watchman.guardian.hand_over(&cause);
                return Err(Failure::Device(cause));
            }
        };
        // What is lost here is made up by the session, which tells silent boards again.
        let _ = session.skin().start_all();
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

    /// Before a turn: the guardian's heartbeat, signals, records.
    fn goes_on(&mut self, session: &mut RealSession, now: Instant) -> bool {
        if let Err(lost) = session.display().watchman.guardian.beat(now) {
            session.set_failure(Failure::Device(format!(
                "{lost}; no guardian is left to switch off after this program"
            )));
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
        while let Some(note) = session.skin().bus_mut().inner.buses.note() {
            session.recorder().note(note.at, note.text);
        }
        self.tell(session);
        !self.journal.has_failed()
    }

    /// Hands what is new to the records.
    fn tell(&mut self, session: &mut RealSession) {
        let frames = session.skin().take_frames();
        let recorder = session.recorder();
        let taxels = recorder.taxels.as_mut().map(Readings::take_frames);
        self.journal
            .tell(&recorder.events, frames, taxels.unwrap_or_default());
    }

    /// Shows a turn; whether the person in front of it wants no more.
    fn is_stopped(&mut self, session: &mut RealSession, now: Instant) -> bool {
        let Some(watch) = &mut self.watch else {
            return false;
        };
        let (skin, recorder) = session.seen();
        let counts = recorder.counts.as_deref().unwrap_or_default();
        let buses = || {
            let all = skin.bus().inner.reports();
            all.iter().map(CanReport::words).collect()
        };
        let stopped = watch.turn(0, now, &recorder.events, counts, buses);
        if stopped {
            let note = "stopped by the person who watched".into();
            session.recorder().note(now, note);
        }
        stopped
    }

    /// Everything off, and the guardian's leave. The screen may take its time; the outputs do not wait for it.
    fn part(&self, session: &mut RealSession, end: Instant) {
        let off = session.switch_off(end);
        let failed = session.failure().is_some();
        let live = session.display();
        let off = off.map_err(|error| live.explain(&error));
        let parted = match (off, failed) {
            (Ok(()), false) => live.watchman.guardian.end(),
            (Ok(()), true) => live.watchman.guardian.end().or(Ok(())), // the first failure is the one to tell
            (Err(cause), _) => {
                live.watchman.guardian.hand_over(&cause);
                Err(cause)
            }
        };
        if let Err(cause) = parted {
            let text = format!("not everything is known to be off: {cause}");
            session.recorder().note(end, text);
            session.set_failure(Failure::Device(cause));
        }
    }
}

/// Real-time priority for this thread, memory that is never paged out for the program.
fn take_priority() -> Result<(), Failure> {
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
fn outcome<D: DisplayEnd>(setup: &Setup, header: Header, mut done: Done<D>) -> Outcome {
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
    summary.can = session.skin().bus().inner.reports();
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
