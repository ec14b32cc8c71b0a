//! A run on a real bench: the same session, paced by the wall clock, between SocketCAN and Linux I2C adapters.

mod bench;
mod clocked;
mod ends;
mod heat;
mod link;
mod loops;
mod passed;
mod records;
mod run;
mod warden;

pub use bench::{Interfaces, refuse_latched, refuse_slow, unguarded, watch};
pub use clocked::{Clocked, OnLines};
pub use ends::lost;
pub use ends::{RealSkin, Sensed, Watched, beat, begin, leave};
pub use heat::{Heat, forget};
pub use link::LinkEnd;
pub use passed::{keep, known};
pub use warden::Live;

use std::borrow::Cow;

use palpate_buses::guardian::{Latch, Latched};
use palpate_buses::lock::BusLock;
use palpate_buses::pacer::RunClock;
use palpate_buses::signals::Signals;
use palpate_buses::sys::{forbid_core_dumps, lock_memory, set_fifo_priority};
use palpate_core::contact::Levels;
use palpate_core::projector::Projector;
use palpate_core::skin::Layout;
use palpate_core::units::{Duration, Instant};
use palpate_files::{BenchKind, Pass, Setup};
use palpate_run::pass::{self, PassReport};
use palpate_run::place::{Place, fingers};
use palpate_run::plan::differences;
use palpate_run::skin_end::Tap;
use palpate_run::{
    CanPlayer, Failure, Input, Outcome, RemoteHeat, Rows, build, plan, scene_end, skin,
};

use crate::link::{RemoteUnit, UnitPlace};
use crate::output::note;
use crate::views::Wanted;

use bench::real_of;
use run::{Run, planned};
use warden::{Wired, banks, haptics};

/// Real-time priority of the loop, below the guardian's.
const PRIORITY: u8 = 50;
/// Time that a run goes on after a recording's last row.
const AFTER: Duration = Duration::from_millis(100);

/// Runs in real time: a scene's length on a real bench, where the world touches the skin, or a scene or recording on
/// the driver unit that the bench names.
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
    if UnitPlace::find(&setup.bench)?.is_none() {
        refuse(setup, input, seed)?;
    }
    let (after, report) = passed(setup, input, seed, wanted)?;
    let mut after = after.into_owned();
    // The ledger of the hardware knows the heat of the pass.
    after.memory.clone_from(&setup.memory);
    for (finger, before) in after.fingers.iter_mut().zip(&setup.fingers) {
        finger.memory.clone_from(&before.memory);
    }
    if report.is_some() {
        wanted.live.map_or(Ok(()), crate::serve::Live::again)?;
    }
    let mut outcome = run_once(&after, input, seed, wanted)?;
    pass::tell(&mut outcome, &after, report);
    if let Some(has_passed) = outcome.has_passed() {
        keep(&after, has_passed)?;
    }
    Ok(outcome)
}

/// Passes the wires of hardware that need it, and keeps that. Returns the setup of what follows and, where there was a pass,
/// the report on it.
///
/// # Errors
/// The failures of [`run()`].
pub fn passed<'a>(
    setup: &'a Setup,
    input: &Input,
    seed: u64,
    wanted: Wanted<'_>,
) -> Result<(Cow<'a, Setup>, Option<PassReport>), Failure> {
    let known = known(setup)?;
    let (after, report) = pass::before(&known, |own| {
        if !wanted.quiet && !wanted.watch {
            note(&pass::announced(own));
        }
        let mut own = own.clone();
        if let (Some(pass), false) = (own.pass.itself(), matches!(input, Input::Scene)) {
            own.pass = Pass::Apart(pass);
        }
        let wanted = Wanted {
            files: &[],
            quiet: true,
            ..wanted
        };
        run_once(&own, &Input::Scene, seed, wanted)
    })?;
    if let Some(report) = &report {
        keep(&after, report.has_passed)?;
    }
    Ok((Cow::Owned(after.into_owned()), report))
}

/// Runs with wires that are as the setup says.
fn run_once(
    setup: &Setup,
    input: &Input,
    seed: u64,
    wanted: Wanted<'_>,
) -> Result<Outcome, Failure> {
    let signals = Signals::catch().map_err(|e| Failure::Device(format!("signals: {e}")))?;
    match UnitPlace::find(&setup.bench)? {
        None => wired(setup, input, seed, signals, wanted),
        Some(place) => on_unit(setup, input, seed, &place, signals, wanted),
    }
}

/// Failure of a run whose loop panicked. It has dropped the guardian's socket, or a unit hears no more: everything is
/// off or about to be.
pub fn panicked() -> Failure {
    let text = "the loop panicked; the guardian or the unit switches everything off";
    Failure::Device(text.into())
}

/// Keeps deaths of this process short: outputs are on until one is noticed.
pub fn dies_at_once() {
    // A core dump would let an abort in the middle of a burst be noticed late; where it cannot be forbidden, the
    // heartbeat notices.
    let _ = forbid_core_dumps();
    // A backtrace takes its time as well: the place has to do.
    std::panic::set_hook(Box::new(|panic| note(&panic.to_string())));
}

/// Runs on boards of this computer.
fn wired(
    setup: &Setup,
    input: &Input,
    seed: u64,
    signals: Signals,
    wanted: Wanted<'_>,
) -> Result<Outcome, Failure> {
    let alone = refuse(setup, input, seed)?;
    let (planned, heat) = planned(setup, alone, seed)?;
    let run = Run::new(setup, planned, signals, wanted)?;
    let (clock, keeps_can) = (RunClock::start(), run.keeps_can());
    let fingers = run.fingers();
    let skins = fingers.iter().map(|finger| {
        let layout = finger.projector.layout();
        let open = match finger.place.name {
            None => Interfaces::open,
            Some(_) => Interfaces::of_boards,
        };
        let can = open(real_of(setup)?, layout, clock)?;
        Ok(skin::source(finger.setup, layout, Tap::new(can, keeps_can)))
    });
    let skins = skins.collect::<Result<Vec<RealSkin>, Failure>>()?;
    // The guardian comes last.
    let (end, skins) = (scene_end(setup), skins.into_iter());
    if let Some(motors) = &setup.bench.value.haptics {
        let make = |_: &Wired<'_>, lines| haptics(motors, lines);
        let (outputs, found) = Live::open(setup, heat, &fingers, clock, make)?;
        return run.until_end(skins.zip(outputs).collect(), &found, clock, end);
    }
    let (outputs, found) = Live::open(setup, heat, &fingers, clock, banks)?;
    run.until_end(skins.zip(outputs).collect(), &found, clock, end)
}

/// Refuses a run that these boards cannot make, before anything is asked of the adapters: that needs no hardware. Returns
/// the fingers of one that they can.
fn refuse(setup: &Setup, input: &Input, seed: u64) -> Result<Vec<(Place, Setup)>, Failure> {
    if !matches!(input, Input::Scene) {
        let expected =
            "--replay, --stream: readings from elsewhere drive an emulated bench or a unit only";
        return Err(Failure::Input(expected.into()));
    }
    refuse_stopped(setup)?;
    let alone = match setup.fingers.is_empty() {
        true => only(setup),
        false => fingers(setup),
    };
    for (_, finger) in &alone {
        refuse_slow(real_of(setup)?, build(finger, seed, Levels::Off)?.guard())?;
    }
    Ok(alone)
}

/// The only display of a bench as a finger.
fn only(setup: &Setup) -> Vec<(Place, Setup)> {
    vec![(Place::whole(&setup.bench.value), setup.clone())]
}

/// Opens the sensor end beside a unit or a network, and tells when its touches end. The end is the bench's own skin,
/// with its frames kept or not, or a recording in its place.
///
/// # Errors
/// [`Failure`] for interfaces that cannot be opened, a scene or recording that fits no skin, or readings that come meanwhile.
pub fn open_skin<'a>(
    setup: &Setup,
    layout: &Layout,
    input: &'a Input,
    seed: u64,
    clock: RunClock,
    keeps: bool,
) -> Result<(Box<dyn Sensed + Send + 'a>, Instant), Failure> {
    Ok(match input {
        Input::Scene
            if setup.bench.value.kind == BenchKind::Real
                && !matches!(setup.pass, Pass::Apart(_)) =>
        {
            let can = Interfaces::open(real_of(setup)?, layout, clock)?;
            let skin = skin::source(setup, layout, Tap::new(can, keeps));
            (Box::new(skin), scene_end(setup))
        }
        Input::Scene => (Box::new(skin::scene(setup, seed, None)?), scene_end(setup)),
        Input::Rows(sources) => {
            let skin = Rows::new(sources, &setup.sensor.value, layout)?;
            let last = sources.iter().map(|s| s.span_us()).max().unwrap_or(0);
            (Box::new(skin), Instant::from_micros(last) + AFTER)
        }
        Input::Frames(frames) => {
            let player = CanPlayer::new(frames.frames()?);
            let skin = skin::source(setup, layout, Tap::new(player, keeps));
            (Box::new(skin), frames.end() + AFTER)
        }
        Input::Stream(_) => {
            return Err(Failure::Input(
                "--stream: expected --replay or the bench's own skin with a unit".into(),
            ));
        }
    })
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
    let instead = "`hil run` drives motors, with their skin on the same machine";
    plan::wires_only(&setup.bench, instead)?;
    refuse_slow(real_of(setup)?, projector.guard())?;
    let place = &Place::whole(&setup.bench.value);
    let only = Wired {
        place,
        setup,
        projector,
    };
    let (mut ends, _) = Live::open(setup, heat, &[only], clock, banks)?;
    ends.pop()
        .ok_or_else(|| Failure::Input("expected a display that is driven, found none".into()))
}

/// Refuses outputs while a stop of them is latched, before anything is opened.
///
/// # Errors
/// [`Failure::Guard`] with the cause of the stop and the way to clear it.
pub fn refuse_stopped(setup: &Setup) -> Result<(), Failure> {
    match UnitPlace::find(&setup.bench)? {
        Some(place) => refuse_stopped_unit(&place),
        None => refuse_latched(&watch(&setup.bench.value, real_of(setup)?)),
    }
}

/// Setup with the limits and boards of its driver unit. Returns the differences of the two, a line each.
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
/// [`Failure::Device`] with the reason for none, [`Failure::Guard`] while a stop is kept.
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
    refuse_stop(place, Latch::new(&hardware).read_locked(&lock))?;
    Ok(LinkEnd::new(unit, RemoteHeat::find(setup), heat, lock))
}

/// Delay from an onset to its effect on a bench's driver unit.
fn delay_ms(setup: &Setup) -> u32 {
    setup.bench.value.unit.as_ref().map_or(0, |u| u.delay_ms)
}

/// Runs on a driver unit: the skin is the bench's own, emulated, or a recording.
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
    let (planned, heat) = planned(&setup, only(&setup), seed)?;
    let setup = &setup;
    let run = Run::new(setup, planned, signals, wanted)?;
    let (keeps_can, layout) = (run.keeps_can(), plan::layout(&setup.sensor.value)?);
    let clock = RunClock::start();
    let (skin, end) = open_skin(setup, &layout, input, seed, clock, keeps_can)?;
    let ends = vec![(skin, open_unit(setup, heat, place, clock)?)];
    run.until_end(ends, "", clock, end)
}

/// Refuses a unit while a stop of a run on it is kept, before it hears of this one.
fn refuse_stopped_unit(place: &UnitPlace) -> Result<(), Failure> {
    refuse_stop(place, Latch::new(&place.hardware()).look())
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

/// Takes real-time priority as a bench wants it: insisted on, done without, or where the system allows it. Returns
/// `true` where the thread has it.
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
