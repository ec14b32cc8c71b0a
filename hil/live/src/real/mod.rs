//! A run on a real bench: the same session, held to the wall clock, between SocketCAN and Linux I2C adapters.

mod bench;
mod clocked;
mod ends;
mod hand;
mod heat;
mod link;
mod loops;
mod records;
mod turns;
mod warden;

pub use bench::{Interfaces, Live, refuse_latched, refuse_slow, unguarded, watch};
pub use clocked::Clocked;
pub use ends::lost;
pub use ends::{RealSkin, Sensed, Watched, beat, begin, leave};
pub use heat::{Heat, forget};
pub use link::LinkEnd;

use palpate_buses::guardian::{Latch, Latched};
use palpate_buses::lock::BusLock;
use palpate_buses::pacer::{Lateness, RunClock, Watch};
use palpate_buses::signals::Signals;
use palpate_buses::sys::{forbid_core_dumps, lock_memory, set_fifo_priority};
use palpate_core::contact::Levels;
use palpate_core::projector::Projector;
use palpate_core::skin::Layout;
use palpate_core::units::{Duration, Instant};
use palpate_files::{BenchKind, Format, Real, Setup};
use palpate_records::readings::Readings;
use palpate_records::trace::{Header, Ledger};
use palpate_run::effort::Effort;
use palpate_run::plan::differences;
use palpate_run::skin_end::Tap;
use palpate_run::{
    AskedLevel, Beginning, CanPlayer, Failure, Input, Outcome, Pacing, RemoteHeat, Rows, Truth,
    attachments, build, dynamic_levels, exceeded, finished, header, scene_levels, skin,
};

use crate::clock;
use crate::interfaces::reports;
use crate::link::{RemoteUnit, UnitPlace};
use crate::output::note;
use crate::progress::Progress;
use crate::record::{About, Journal, Sink};
use crate::views::{Views, Wanted};

use turns::{Done, Turns};

/// Real-time priority of the loop, below the guardian's.
const PRIORITY: u8 = 50;

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
    dies_at_once();
    let signals = Signals::catch().map_err(|e| Failure::Device(format!("signals: {e}")))?;
    match UnitPlace::of(&setup.bench)? {
        None => wired(setup, input, seed, signals, wanted),
        Some(place) => on_unit(setup, input, seed, &place, signals, wanted),
    }
}

/// Lets no death of this process take its time: outputs are on until it is noticed.
pub fn dies_at_once() {
    // What lets an abort in the middle of a burst be noticed late; refused, it is noticed by the heartbeat.
    let _ = forbid_core_dumps();
    // A backtrace takes its time as well: the place has to do.
    std::panic::set_hook(Box::new(|panic| note(&panic.to_string())));
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
    refuse_stopped(setup)?;
    let real = real_of(setup)?;
    if !setup.fingers.is_empty() {
        let started = clock::elapsed();
        let mut outcome = hand::run((setup, real), seed, &signals, wanted)?;
        outcome.summary.wall_s = clock::elapsed().saturating_sub(started).as_secs_f64();
        return Ok(outcome);
    }
    refuse_slow(real, build(setup, seed, Levels::Off)?.guard())?;
    let (setup, heat) = Heat::alone(setup)?;
    let setup = &setup;
    let run = Running::begin(setup, seed, signals, wanted)?;
    let layout = run.projector.layout();
    let clock = RunClock::start();
    // The guardian last.
    let skin = open_skin(setup, layout, clock, run.keeps_can)?;
    let live = open_outputs(setup, heat, &run.projector, clock)?;
    run.until_end((skin, live), clock, scene_end(setup))
}

/// The boards on a bench's interfaces, with their frames kept or not.
///
/// # Errors
/// [`Failure`] for an emulated bench, or interfaces that cannot be opened.
pub fn open_skin(
    setup: &Setup,
    layout: &Layout,
    clock: RunClock,
    keeps: bool,
) -> Result<RealSkin, Failure> {
    let can = Interfaces::open(real_of(setup)?, layout, clock)?;
    Ok(skin::source(setup, layout, Tap::new(can, keeps)))
}

/// The boards on a bench's adapters, by the run's clock, and the guardian over them. Their heat is booked with `heat`.
///
/// # Errors
/// [`Failure`] for an emulated bench, a stop that is latched, or adapters that cannot be opened.
pub fn open_outputs(
    setup: &Setup,
    heat: Heat,
    projector: &Projector,
    clock: RunClock,
) -> Result<Live, Failure> {
    let (bench, real) = (&setup.bench.value, real_of(setup)?);
    refuse_slow(real, projector.guard())?;
    Live::open((bench, real), heat, projector.guard().prescale(), clock)
}

/// Refuses outputs while a stop of them is latched, before anything is opened.
///
/// # Errors
/// [`Failure::Guard`] with what stopped them and how that is cleared.
pub fn refuse_stopped(setup: &Setup) -> Result<(), Failure> {
    match UnitPlace::of(&setup.bench)? {
        Some(place) => refuse_stopped_unit(&place),
        None => refuse_latched(&watch(&setup.bench.value, real_of(setup)?)),
    }
}

/// The setup with what its driver unit says of itself, and where the two differ, a line each.
///
/// # Errors
/// [`Failure`] for a unit that does not answer or is no unit for this bench.
pub fn met(setup: &Setup, place: &UnitPlace) -> Result<(Setup, Vec<String>), Failure> {
    let mut setup = setup.clone();
    let mut unit = RemoteUnit::open(place, delay_ms(&setup), RunClock::start())?;
    setup.unit = Some(unit.ask(1)?.0);
    let notes = differences(&setup)?;
    Ok((setup, notes))
}

/// A session with the driver unit of a setup that was [`met`], for as long as it lives the only one of this computer. Its heat
/// is booked with `heat`.
///
/// # Errors
/// [`Failure::Device`] with why there is none, [`Failure::Guard`] while a stop is kept.
pub fn open_unit(
    setup: &Setup,
    heat: Heat,
    place: &UnitPlace,
    clock: RunClock,
) -> Result<LinkEnd, Failure> {
    let mut unit = RemoteUnit::open(place, delay_ms(setup), clock)?;
    unit.connect()?;
    let hardware = place.hardware();
    let lock = BusLock::take(&hardware).map_err(|e| Failure::Device(e.to_string()))?;
    refuse_stop(place, Latch::of(&hardware).read_locked(&lock))?;
    Ok(LinkEnd::new(unit, RemoteHeat::of(setup), heat, lock))
}

/// From an onset to its effect on a bench's driver unit.
fn delay_ms(setup: &Setup) -> u32 {
    setup.bench.value.unit.as_ref().map_or(0, |u| u.delay_ms)
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
    refuse_stopped_unit(place)?;
    let (setup, mut notes) = met(setup, place)?;
    if !setup.scene.value.faults.is_empty() {
        notes
            .push("the scene's faults are left out: a unit's hardware is not emulated here".into());
    }
    if !wanted.quiet {
        notes.iter().for_each(|text| note(text));
    }
    let (setup, heat) = Heat::alone(&setup)?;
    let setup = &setup;
    let run = Running::begin(setup, seed, signals, wanted)?;
    let (layout, keeps_can) = (run.projector.layout(), run.keeps_can);
    let clock = RunClock::start();
    let open = move || open_unit(setup, heat, place, clock);
    let after = |last: Instant| last + Duration::from_millis(100);
    match input {
        Input::Scene if setup.bench.value.kind == BenchKind::Real => {
            let skin = open_skin(setup, layout, clock, keeps_can)?;
            run.until_end((skin, open()?), clock, scene_end(setup))
        }
        Input::Scene => {
            let skin = skin::scene(setup, seed, None)?;
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

/// Refuses a unit while a stop of a run on it is kept, before it hears of this one.
fn refuse_stopped_unit(place: &UnitPlace) -> Result<(), Failure> {
    refuse_stop(place, Latch::of(&place.hardware()).look())
}

/// Refuses a unit of which this stop is kept.
fn refuse_stop(place: &UnitPlace, held: Option<Latched>) -> Result<(), Failure> {
    match held {
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

/// The intensity levels of a scene's own touches; without touches they are found frame by frame.
fn levels(setup: &Setup, seed: u64) -> Result<Levels, Failure> {
    let scene = &setup.scene.value;
    match scene.touches.is_empty() {
        true => Ok(dynamic_levels(&scene.compression)),
        false => scene_levels(setup, seed),
    }
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
    wanted: Wanted<'a>,
    started: std::time::Duration,
}

impl<'a> Running<'a> {
    fn begin(
        setup: &'a Setup,
        seed: u64,
        signals: Signals,
        wanted: Wanted<'a>,
    ) -> Result<Self, Failure> {
        let started = clock::elapsed();
        let scene = &setup.scene.value;
        let projector = build(setup, seed, levels(setup, seed)?)?;
        let (header, attached) = (header(setup, seed, &projector)?, attachments(setup));
        let writes = |format: Format| wanted.files.iter().any(|(other, _)| *other == format);
        let decoded = || Readings::whole(projector.layout(), scene.drives);
        let taxels = writes(Format::Mcap).then(decoded);
        let modules = taxels.as_ref().map_or(&[][..], Readings::modules);
        let about = About::Run(&header, modules, &attached);
        let sinks = Sink::create_all(wanted.files, &about, wanted.outputs)?;
        let journal = Journal::start(sinks, !wanted.quiet && !wanted.watch)?;
        Ok(Self {
            setup,
            keeps_can: writes(Format::Candump) || writes(Format::Mcap),
            projector,
            header,
            signals,
            journal,
            taxels,
            wanted,
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
        let mut views = Views::default();
        views.begin(
            self.wanted,
            &Beginning {
                setup,
                header: &self.header,
                projector: &self.projector,
                end: length,
                display: None,
            },
        )?;
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
            views,
            progress: Progress::of_part("run"),
            watch: Watch::default(),
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

/// Real-time priority as a bench wants it: insisted on, done without, or taken where the system allows it. Whether it was.
///
/// # Errors
/// [`Failure::Device`] where it is insisted on and not allowed.
pub fn priority(wanted: Option<bool>) -> Result<bool, Failure> {
    match wanted {
        Some(false) => Ok(false),
        None => Ok(take_priority().is_ok()),
        Some(true) => take_priority().map(|()| true),
    }
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
        margins: exceeded(session.projector().guard()),
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
    summary.heat = session.display().heat();
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
