//! A run on a real bench: the same loop, held to the wall clock, between SocketCAN and Linux I2C adapters.

mod bench;
mod report;
mod signals;

pub use bench::watch;
pub use report::{CanReport, Pacing};
pub use signals::Signals;
pub use std::path::PathBuf;

use palpate_buses::can::CanBuses;
use palpate_buses::pacer::{Lateness, Pacer};
use palpate_buses::sys::{forbid_core_dumps, lock_memory, set_fifo_priority};
use palpate_core::bus::SensorBus;
use palpate_core::contact::Levels;
use palpate_core::projector::{Cause, LoopError, Projector};
use palpate_core::units::{Duration, Instant};
use palpate_core::wire::uskin::Command;
use palpate_records::trace::{Event, Ledger, Trace};

use super::effort::{Effort, FrameTimes};
use super::ends::{attachments, header};
use super::recorder::Recorder;
use super::summary::TextureSummary;
use super::supervisor::Supervisor;
use super::{Outcome, Summary, TICK, boards, build, open_watch, scene_levels};
use crate::clock;
use crate::failure::Failure;
use crate::output::note;
use crate::record::{About, Journal, Kind, Sink, Tap};
use crate::watch::Watch;
use palpate_files::{Real, Setup};

use bench::Live;

/// Real-time priority of the loop, below the guardian's.
const PRIORITY: u8 = 50;

/// An adapter that is gone may come back within this time: a USB plug that was pulled and put in again.
const GIVE_UP: Duration = Duration::from_millis(3000);
/// How often a bus that is lost is tried.
const RETRY: Duration = Duration::from_millis(20);
/// Registers are read back this often.
const LOOK: Duration = Duration::from_millis(250);

/// What the loop leaves behind.
struct Done {
    projector: Projector,
    recorder: Recorder,
    frame_us: Vec<f32>,
    effort: Effort,
    lateness: Lateness,
    realtime: bool,
    can: Vec<CanReport>,
    not_recorded: u64,
    end: Instant,
    failure: Option<Failure>,
}

/// Who is told about a run while it goes on.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Told {
    /// Nobody, but of errors.
    pub quiet: bool,
    /// Somebody in front of a live view, which notes would tear.
    pub watched: bool,
}

/// Runs a scene's length on a real bench: what touches the skin is up to the world. `files` grow while it
/// runs; unless `quiet`, what happens to the bench is told on standard error.
///
/// # Errors
/// [`Failure`] for input that fits no loop, or a bench that cannot be opened or started.
pub fn run(
    setup: &Setup,
    seed: u64,
    files: &[(Kind, PathBuf)],
    told: Told,
) -> Result<Outcome, Failure> {
    let started = clock::now();
    let (scene, bench) = (&setup.scene.value, &setup.bench.value);
    let Some(real) = &bench.real else {
        return Err(Failure::Input(format!(
            "bench `{}`: expected kind = \"real\"",
            bench.name
        )));
    };
    // An abort in the middle of a burst must be noticed at once; refused, it is noticed by the heartbeat.
    let _ = forbid_core_dumps();
    // A backtrace takes its time, and outputs are on while it is made: the place has to do.
    std::panic::set_hook(Box::new(|panic| note(&panic.to_string())));
    let signals = Signals::catch().map_err(|e| Failure::Device(format!("signals: {e}")))?;
    let levels = if scene.touches.is_empty() {
        Levels::Dynamic(u16::try_from(scene.compression.ki).unwrap_or(u16::MAX))
    } else {
        scene_levels(setup, seed)?
    };
    let projector = build(setup, seed, levels)?;
    let (header, attached) = (header(setup, seed, &projector)?, attachments(setup));
    let sinks = Sink::create_all(files, &About::Run(&header, &attached))?;
    let journal = Journal::start(sinks, !told.quiet && !told.watched)?;
    let keeps_can = |kind: Kind| matches!(kind, Kind::Can | Kind::Mcap);
    let keeps_can = files.iter().any(|(kind, _)| keeps_can(*kind));
    let (live, can) = Live::open(bench, real, projector.layout())?;
    let length = Instant::from_micros((scene.length_s * 1e6).round() as u64);
    let watch = match told.watched {
        true => open_watch(setup, seed, &projector, length, false)?,
        false => None,
    };
    let done = std::thread::scope(|scope| {
        let records = (journal, keeps_can, watch);
        let turns = || drive(live, can, projector, real, &signals, length, records);
        let thread = std::thread::Builder::new()
            .name("loop".into())
            .spawn_scoped(scope, turns);
        let thread = thread.map_err(|e| Failure::Device(format!("the loop's thread: {e}")))?;
        // A panic has dropped the guardian's socket: everything is off or about to be.
        let panicked =
            |_| Failure::Device("the loop panicked; the guardian switches everything off".into());
        thread.join().map_err(panicked)?
    })?;
    outcome(setup, seed, done, started)
}

/// The loop on its own thread, until the scene's end, a signal, or a failure.
fn drive(
    mut live: Live,
    can: CanBuses,
    mut projector: Projector,
    real: &Real,
    signals: &Signals,
    length: Instant,
    (mut journal, keeps_can, mut watch): (Journal, bool, Option<Watch>),
) -> Result<Done, Failure> {
    let mut recorder = Recorder::new(None, projector.layout());
    recorder.counts = watch.is_some().then(Vec::new);
    let realtime = match real.realtime {
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
    let ready = match live.start() {
        Ok(ready) => ready,
        Err(error) => {
            let cause = live.explain(&error);
            live.watchman.guardian.hand_over(&cause);
            return Err(Failure::Device(cause));
        }
    };
    let mut can = Tap::new(can, keeps_can);
    start_boards(&mut can, &projector);
    let mut supervisor = Supervisor::patient(GIVE_UP);
    let mut pacer = Pacer::new(live.clock);
    let mut times = FrameTimes::default();
    let mut effort = Effort::default();
    let mut failure = None;
    let mut next_look = Instant::ZERO;
    let mut now = pacer.wait(ready);
    let end = Instant::from_micros(length.as_micros().saturating_add(now.as_micros()));
    while now < end {
        if let Err(lost) = live.watchman.guardian.beat(now) {
            failure = Some(Failure::Device(format!(
                "{lost}; nobody is left to switch off after this program"
            )));
            break;
        }
        if let Some(signal) = signals.caught() {
            recorder.note(now, format!("stopped by {signal}"));
            break;
        }
        assert!(
            !signals.wants_panic(),
            "a drill, by PALPATE_DRILL and SIGUSR1"
        );
        can.now = now;
        while let Some(note) = can.inner.note() {
            recorder.note(note.at, note.text);
        }
        journal.tell(&recorder.events, can.take());
        if journal.has_failed() {
            break;
        }
        if supervisor.is_lost() {
            let Live {
                banks, watchman, ..
            } = &mut live;
            match supervisor.recover(now, banks, watchman, &mut recorder.events) {
                Ok(_) => {
                    now = pacer.wait(Pacer::next(live.clock.now(), RETRY));
                    continue;
                }
                Err(e) => {
                    failure = Some(e);
                    break;
                }
            }
        }
        match projector.guard().latched() {
            // The boards were started anew and read back: a transient fault of the bus is over.
            Some(Cause::ActuatorError) => {
                supervisor.resume(now, &mut projector, &mut live.banks, &mut recorder.events);
            }
            // Outputs stay off until a person has looked; the skin is still read and recorded.
            Some(cause) if failure.is_none() => {
                let cause = why(cause);
                recorder.note(now, format!("stopped: {cause}"));
                // A guardian that is gone ends the run at the next heartbeat.
                let _ = live.watchman.guardian.stop(cause);
                failure = Some(stopped(real, cause));
            }
            _ => {}
        }
        let before = recorder.frames;
        let begun = clock::now();
        let polled = projector.poll(now, &mut can, &mut live.banks, &mut recorder);
        let frames = recorder.frames - before;
        times.add(begun, frames, &projector.work(), &mut effort);
        let polled = match polled {
            // A chip that fell back to reset values answers, but sleeps, and nothing on the bus says so. Asked
            // between two bursts, so that a slow answer delays no end of one.
            Ok(_) if now >= next_look && projector.guard().next_expiry().is_none() => {
                next_look = now + LOOK;
                live.banks.verify().inspect_err(|_| {
                    // The error is on its way; recovery finds out whether this helped.
                    let _ = projector.all_off(
                        now,
                        Cause::ActuatorError,
                        &mut live.banks,
                        &mut recorder,
                    );
                })
            }
            Ok(_) => Ok(()),
            Err(LoopError::Actuator(e)) => Err(e),
            Err(LoopError::Sensor(e)) => {
                failure = Some(Failure::Device(format!("sensor bus: {e}")));
                break;
            }
        };
        supervisor.retried(now, live.banks.retries(), &mut recorder.events);
        if let Err(error) = polled {
            let error = live.explain(&error);
            supervisor.lose(now, &error, &live.watchman, &mut recorder.events);
        }
        supervisor.restart_boards(now, &mut can, &projector, &mut recorder.events);
        if let Some(watch) = &mut watch {
            let counts = recorder.counts.as_deref().unwrap_or_default();
            let buses = || {
                reports(real, &can.inner)
                    .iter()
                    .map(CanReport::words)
                    .collect()
            };
            if watch.turn(now, &recorder.events, counts, buses) {
                recorder.note(now, "ended by the person who watched".into());
                break;
            }
        }
        let next = projector.next().min(Pacer::next(now, TICK));
        now = pacer.wait(next);
    }
    let end = live.clock.now();
    // The screen may take its time; the outputs do not wait for it.
    let off = projector.all_off(end, Cause::End, &mut live.banks, &mut recorder);
    let off = off.map_err(|error| live.explain(&error));
    let reported = reports(real, &can.inner);
    let parted = match (off, failure.is_some()) {
        (Ok(()), false) => live.watchman.guardian.end(),
        (Ok(()), true) => live.watchman.guardian.end().or(Ok(())), // the first failure is the one to tell
        (Err(cause), _) => {
            live.watchman.guardian.hand_over(&cause);
            Err(cause)
        }
    };
    if let Err(cause) = parted {
        recorder.note(end, format!("not everything is known to be off: {cause}"));
        failure.get_or_insert(Failure::Device(cause));
    }
    recorder.tell_taxels();
    recorder.tell(&mut effort, projector.display().wires().len());
    effort.traffic = live.banks.traffic();
    journal.tell(&recorder.events, can.take());
    let not_recorded = journal.dropped();
    if let Err(error) = journal.finish() {
        failure.get_or_insert(error);
    }
    drop(watch);
    Ok(Done {
        projector,
        recorder,
        frame_us: times.us,
        effort,
        lateness: pacer.lateness().clone(),
        realtime,
        can: reported,
        not_recorded,
        end,
        failure,
    })
}

/// What every interface has been through.
fn reports(real: &Real, can: &CanBuses) -> Vec<CanReport> {
    let tallies = can.tallies();
    let named = real.can.iter().zip(&tallies);
    named
        .map(|(name, tally)| CanReport::new(name, tally))
        .collect()
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

/// What the guard stopped a run for.
const fn why(cause: Cause) -> &'static str {
    match cause {
        Cause::StaleInput => "stale-input: no sensor frame for 100 ms while a wire was driven",
        Cause::LateTick => "late-tick: this computer was too late to end a stimulus in time",
        other => other.word(),
    }
}

/// A run whose outputs the guard has switched off for good, with the way back.
fn stopped(real: &Real, cause: &str) -> Failure {
    let buses = real
        .i2c
        .iter()
        .map(|bus| format!(" --i2c {}", bus.display()));
    Failure::Guard(format!(
        "{cause}; outputs are off and stay off. Look at the bench, then clear the stop: hil off --unlatch{}",
        buses.collect::<String>()
    ))
}

/// Tells every board of the layout to send.
fn start_boards(can: &mut impl SensorBus, projector: &Projector) {
    for address in projector
        .layout()
        .modules()
        .iter()
        .filter_map(|m| m.address())
    {
        let command = Command {
            board: address.board,
            start: true,
        };
        if let Some(frame) = command.encode() {
            // What is lost here is made up by the supervisor, which tells silent boards again.
            let _ = can.transmit(address.bus, &frame);
        }
    }
}

/// The run on paper.
fn outcome(
    setup: &Setup,
    seed: u64,
    mut done: Done,
    started: std::time::Instant,
) -> Result<Outcome, Failure> {
    let bench = &setup.bench.value;
    let mut events = std::mem::take(&mut done.recorder.events);
    events.sort_by_key(Event::t_ns);
    let trace = Trace {
        header: header(setup, seed, &done.projector)?,
        events,
        ledger: Ledger {
            limiter_events: done.recorder.limiter_events,
            length_us: done.end.as_micros(),
            ..Ledger::default()
        },
    };
    let health = done.projector.health(done.end);
    let wall = started.elapsed();
    let mut summary = Summary::new(&trace, &done.recorder, &done.frame_us, &health, bench, wall);
    summary.texture = TextureSummary::of(&done.recorder, &done.projector);
    summary.boards = boards::boards(&done.projector);
    summary.taxels.list(&done.projector, done.end);
    summary.pacing = Some(Pacing::new(&done.lateness, done.realtime));
    summary.can = done.can;
    summary.frames_not_recorded = done.not_recorded;
    Ok(Outcome {
        // Nothing measures a real finger.
        warmth: Vec::new(),
        skin_limits: super::margins::skin_limits(&setup.limits.value),
        trace,
        summary,
        frame_us: done.frame_us,
        effort: done.effort,
        can: Vec::new(),
        i2c: Vec::new(),
        notes: Vec::new(),
        failure: done.failure,
    })
}
