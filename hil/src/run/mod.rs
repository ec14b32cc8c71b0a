//! A run: a scene or a recording through the loop onto an emulated display, in virtual time; or the loop on
//! a [real] bench, held to the wall clock.

mod boards;
mod effects;
pub mod effort;
pub(crate) mod ends;
mod feel;
mod margins;
pub mod real;
mod recorder;
mod replay;
pub(crate) mod script;
mod sensor;
pub(crate) mod skin;
mod summary;
pub(crate) mod supervisor;
mod tape;

pub use boards::{BoardReport, BusReport, Spread};
pub use ends::attachments;
pub use recorder::um;
pub use script::FaultReport;
pub use summary::{IllTaxel, Summary, Taxels};

use std::convert::Infallible;
use std::path::PathBuf;

use palpate_core::bus::{Actuators, Received};
use palpate_core::contact::{LevelTable, Levels};
use palpate_core::driver::Banks;
use palpate_core::guard::Guarded;
use palpate_core::projector::{Cause, LoopError, Projector};
use palpate_core::units::{Duration, Instant};
use palpate_emulators::can::faults::Faulty;
use palpate_emulators::i2c::fault::{I2cFault, I2cFaults, Shared};
use palpate_emulators::time::Nanos;
use palpate_records::i2c::Transfer;
use palpate_records::report::{SkinLimits, Warmth};
use palpate_records::trace::{Event, Ledger, Trace};

use crate::clock;
use crate::failure::Failure;
use crate::files::Setup;
use crate::output::note;
use crate::plan;
use crate::watch::Watch;

use effort::Effort;
use ends::{display, header};
use feel::{feel, sample_wires};
use recorder::{Onset, Recorder};
use replay::Replay;
use script::{Bench, Script};
use sensor::{Skin, Tapped};
use supervisor::Supervisor;
use tape::Tape;

/// The loop is called at least this often, as a real host would call it.
const TICK: Duration = Duration::from_millis(1);

/// What drives the sensor end.
#[derive(Clone, Debug)]
pub enum Input {
    /// The scene's touches on an emulated skin.
    Scene,
    /// Recorded rows, one file a module, at a rate where the files have no times; or one candump log.
    Replay {
        /// The files.
        paths: Vec<PathBuf>,
        /// Rows a second.
        rate_hz: Option<f64>,
    },
}

/// A finished run.
#[derive(Debug)]
pub struct Outcome {
    /// Everything that happened.
    pub trace: Trace,
    /// What it came to.
    pub summary: Summary,
    /// Computing time of each frame, microseconds.
    pub frame_us: Vec<f32>,
    /// Temperatures over time.
    pub warmth: Vec<Warmth>,
    /// The skin's limits in force.
    pub skin_limits: SkinLimits,
    /// What was done and what was left out.
    pub effort: Effort,
    /// What ended the run before its time; the outputs are off.
    pub failure: Option<Failure>,
    /// Frames on the sensor buses as the host saw them, if they were to be kept.
    pub can: Vec<Received>,
    /// Messages on the actuator buses, if they were to be kept.
    pub i2c: Vec<Transfer>,
    /// Remarks for the user, such as a recording that ends too early.
    pub notes: Vec<String>,
}

/// What a run keeps beside its trace.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Keep {
    /// Every frame on the sensor buses: 24 bytes each, 1600 a second for a module of 16 taxels at 100 Hz.
    pub can: bool,
    /// Every message on the actuator buses.
    pub i2c: bool,
    /// Nothing, but shows it all on a terminal while it comes; virtual time is held to the wall clock.
    pub watch: bool,
}

/// The finger is looked at no less often than this, even where no stimulus comes.
const LOOK: Duration = Duration::from_millis(250);

/// Transfers kept of a run's actuator bus, the last ones: some hours of them.
const I2C_LOG: usize = 1 << 20;

/// Nobody listens: for a pass that only looks at contacts.
struct Silence;

impl Actuators for Silence {
    type Error = Infallible;

    fn apply(&mut self, _update: &Guarded) -> Result<(), Infallible> {
        Ok(())
    }

    fn all_off(&mut self) -> Result<(), Infallible> {
        Ok(())
    }
}

/// Runs a scene on an emulated bench.
///
/// # Errors
/// [`Failure`] for input that fits no loop, or a bus that fails.
pub fn run(setup: &Setup, input: &Input, seed: u64) -> Result<Outcome, Failure> {
    run_keeping(setup, input, seed, Keep::default())
}

/// [`run`], keeping more.
///
/// # Errors
/// As [`run`].
pub fn run_keeping(
    setup: &Setup,
    input: &Input,
    seed: u64,
    keep: Keep,
) -> Result<Outcome, Failure> {
    let started = (clock::now(), keep.watch);
    let layout = plan::layout(&setup.sensor.value)?;
    let scene = &setup.scene.value;
    match input {
        Input::Scene => {
            let end = Instant::from_micros((scene.length_s * 1e6).round() as u64);
            let skin = || skin::emulated(scene, &setup.sensor.value, &layout, seed);
            let mut tape = Tape::new(skin()?);
            let levels = calibrate(setup, seed, &mut tape, end)?;
            let truth = || Some((scene.touches.clone(), scene.drives));
            if scene.faults.is_empty() && tape.is_exact() {
                tape.rewind(end);
                let mut tape = Tapped::new(tape, keep);
                let levels = levels.clone();
                let outcome = project(setup, seed, levels, &mut tape, truth(), end, started)?;
                if tape.inner().is_exact() {
                    return Ok(outcome);
                }
            }
            let faulty = Faulty::new(skin()?, seed, "sensor bus");
            let mut faulty = Tapped::new(faulty, keep);
            project(setup, seed, levels, &mut faulty, truth(), end, started)
        }
        Input::Replay { paths, rate_hz } => {
            let mut first = Replay::open(paths, &setup.sensor.value, &layout, *rate_hz)?;
            let mut second = Tapped::new(first.clone(), keep);
            let notes = first.take_notes();
            if first.rows() <= scene.reference_frames as usize {
                return Err(Failure::Input(format!(
                    "{}: expected more than the {} reference rows, found {}",
                    paths
                        .first()
                        .map(|p| p.display().to_string())
                        .unwrap_or_default(),
                    scene.reference_frames,
                    first.rows()
                )));
            }
            let end = first.end() + Duration::from_millis(100);
            let levels = calibrate(setup, seed, &mut first, end)?;
            let mut outcome = project(setup, seed, levels, &mut second, None, end, started)?;
            outcome.notes = notes;
            Ok(outcome)
        }
    }
}

/// The static intensity levels of a scene's own touches on an emulated skin: what a live run goes by, since
/// it cannot see its whole input beforehand.
fn scene_levels(setup: &Setup, seed: u64) -> Result<Levels, Failure> {
    let scene = &setup.scene.value;
    let layout = plan::layout(&setup.sensor.value)?;
    let end = Instant::from_micros((scene.length_s * 1e6).round() as u64);
    let mut skin = Tape::new(skin::emulated(scene, &setup.sensor.value, &layout, seed)?);
    calibrate(setup, seed, &mut skin, end)
}

/// A first pass that finds the static intensity levels over the whole input.
fn calibrate(
    setup: &Setup,
    seed: u64,
    skin: &mut impl Skin,
    end: Instant,
) -> Result<Levels, Failure> {
    let k = setup.scene.value.compression.ki as usize;
    if k <= 1 {
        return Ok(Levels::Off); // every contact has the one level there is
    }
    let mut projector = build(setup, seed, Levels::Off)?;
    let mut recorder = Recorder::default();
    let mut now = Instant::ZERO;
    while now < end {
        skin.advance_to(now);
        let polled = projector.poll(now, skin, &mut Silence, &mut recorder);
        if let Err(LoopError::Sensor(e)) = polled {
            return Err(Failure::Device(format!("sensor bus: {e:?}")));
        }
        now = projector.next().min(now + TICK);
    }
    match LevelTable::from_intensities(&recorder.intensities, k) {
        Ok(table) => Ok(Levels::Table(table)),
        Err(_) => Ok(Levels::Off), // nothing was touched
    }
}

fn build(setup: &Setup, seed: u64, levels: Levels) -> Result<Projector, Failure> {
    let plan = plan::plan(setup, seed, levels)?;
    Projector::new(plan).map_err(|e| Failure::Input(format!("{}: {e}", setup.scene.source.label())))
}

/// The pass that counts: the loop between the skin and the emulated display. The whole run began at
/// `started`, by the wall clock, and may be `watched`.
fn project(
    setup: &Setup,
    seed: u64,
    levels: Levels,
    skin: &mut Tapped<impl Skin>,
    truth: Option<(Vec<crate::files::Touch>, usize)>,
    end: Instant,
    (started, watched): (std::time::Instant, bool),
) -> Result<Outcome, Failure> {
    let bench = &setup.bench.value;
    let prescale = plan::prescale(bench)?;
    let drive = plan::drive(&setup.scene.value.illusion);
    let mut projector = build(setup, seed, levels)?;
    let mut display = display(setup, projector.display().wires())?;
    display.keep_flows();
    if skin.keeps().i2c {
        let kept = display.bus().with(|bus| bus.keep_log(I2C_LOG));
        kept.map_err(|e| Failure::Device(format!("actuator bus: {e}")))?;
    }
    let mut recorder = Recorder::new(truth, projector.layout());
    let mut watch = match watched {
        true => open_watch(setup, seed, &projector, end, true)?,
        false => None,
    };
    recorder.counts = watch.is_some().then(Vec::new);
    let i2c = Shared::new(I2cFault::new(
        display.bus(),
        I2cFaults::default(),
        seed,
        "actuator bus",
    ));
    let mut bank = Banks::new([(i2c.clone(), &*plan::boards(bench))], prescale);
    let mut script = Script::new(&setup.scene.value.faults, projector.layout());
    let mut supervisor = Supervisor::default();
    let device = |e: &dyn std::fmt::Display| Failure::Device(e.to_string());

    for (board, _) in plan::boards(bench).iter().enumerate() {
        let board = board as u8; // at most 16
        recorder.events.push(Event::AllOff {
            t_us: 0,
            board,
            cause: "start",
        });
        recorder.events.push(Event::PreScale {
            t_us: 0,
            board,
            pre_scale: prescale.get(),
        });
    }
    macro_rules! hardware {
        () => {
            Bench {
                skin: skin.emulated(),
                i2c: &i2c,
                display: &mut display,
                oscillator: bench.drive.oscillator,
            }
        };
    }
    script.step(Instant::ZERO, &mut hardware!(), &mut recorder.events);
    let mut now = match bank.start(Instant::ZERO) {
        Ok(ready) => ready,
        Err(e) => {
            supervisor.lose(Instant::ZERO, &e, &display, &mut recorder.events);
            Instant::ZERO
        }
    };

    let mut samples = Vec::new();
    let mut look = Instant::ZERO;
    let (mut frame_us, mut spent) = (Vec::new(), std::time::Duration::ZERO);
    let mut pending: Option<Onset> = None;
    let (mut failure, mut stopped) = (None, false);
    let mut effort = Effort::default();
    while now < end {
        skin.advance_to(now);
        let edges = &mut recorder.events;
        display
            .advance(Nanos::from(now), &mut |e| edges.push(edge(&e)))
            .map_err(|e| device(&e))?;
        if supervisor.is_lost() {
            match supervisor.recover(now, &mut bank, &display, &mut recorder.events) {
                Ok(Some(ready)) => now = ready,
                Ok(None) => {
                    script.step(now, &mut hardware!(), &mut recorder.events);
                    now += TICK;
                }
                Err(e) => {
                    failure = Some(e);
                    break;
                }
            }
            continue;
        }
        supervisor.resume(now, &mut projector, &mut bank, &mut recorder.events);
        let before = recorder.frames;
        let begun = clock::now();
        let polled = projector.poll(now, skin, &mut bank, &mut recorder);
        spent += begun.elapsed();
        let polled = match polled {
            // A chip that fell back to reset values answers, but sleeps: ask while wires should be driven.
            Ok(true) => bank.verify().map(|()| true).inspect_err(|_| {
                // The error is on its way; recovery finds out whether this helped.
                let _ = projector.all_off(now, Cause::ActuatorError, &mut bank, &mut recorder);
            }),
            Ok(false) => Ok(false),
            Err(LoopError::Actuator(e)) => Err(e),
            Err(LoopError::Sensor(e)) => {
                failure = Some(Failure::Device(format!("sensor bus: {e:?}")));
                break;
            }
        };
        supervisor.retried(now, bank.retries(), &mut recorder.events);
        let onset = polled.unwrap_or_else(|e| {
            supervisor.lose(now, &e, &display, &mut recorder.events);
            false
        });
        if recorder.frames > before {
            let frames = recorder.frames - before;
            let each = spent.as_secs_f32() * 1e6 / frames as f32;
            frame_us.extend(std::iter::repeat_n(each, frames as usize));
            effort.note(&projector.work(), frames, each);
            spent = std::time::Duration::ZERO;
        }
        if onset {
            feel(pending.take(), &display, &projector, drive, &mut recorder);
            pending = recorder.onset.take();
            sample_wires(now, &mut display, &projector, &mut recorder);
        }
        if onset || now >= look {
            samples.extend(display.sample());
            look = now + LOOK;
        }
        supervisor.restart_boards(now, skin, &projector, &mut recorder.events);
        if let Some(watch) = &mut watch {
            let counts = recorder.counts.as_deref().unwrap_or_default();
            let buses = || skin.buses().iter().map(BusReport::words).collect();
            if watch.turn(now, &recorder.events, counts, buses) {
                recorder.note(now, "ended by the person who watched".into());
                stopped = true;
                break;
            }
        }
        script.step(now, &mut hardware!(), &mut recorder.events);
        now = projector.next().min(now + TICK).min(script.next());
    }
    drop(watch);
    feel(pending, &display, &projector, drive, &mut recorder);
    let end = if failure.is_some() || stopped {
        now
    } else {
        end
    };
    let off = projector.all_off(end, Cause::End, &mut bank, &mut recorder);
    if let Err(e) = off
        && failure.is_none()
    {
        supervisor.lose(end, &e, &display, &mut recorder.events);
        failure = Some(device(&e));
    }
    script.finish(end, &mut hardware!(), &mut recorder.events);
    // Full off takes effect at the end of a period: wait for two of them.
    let settled = Nanos::from(end) + Nanos(2 * prescale.period_ns());
    let edges = &mut recorder.events;
    display
        .advance(settled, &mut |e| edges.push(edge(&e)))
        .map_err(|e| device(&e))?;
    recorder.tell_taxels();

    samples.extend(display.sample());
    let i2c = boards::transfers(&display);
    let totals = display.totals();
    let mut events = std::mem::take(&mut recorder.events);
    events.sort_by_key(Event::t_ns);
    let ledger = Ledger {
        energy_uj: (totals.electrical_j * 1e6).round() as u64,
        peak_supply_ma: totals.peak_supply.0,
        hottest_wire: milli_c(totals.hottest_wire.0).map(|t| (t, totals.hottest_wire.1 as u16)),
        hottest_skin_milli_c: milli_c(totals.hottest_skin_c),
        limiter_events: recorder.limiter_events,
        length_us: end.as_micros(),
    };
    let trace = Trace {
        header: header(setup, seed, &projector)?,
        events,
        ledger,
    };
    skin.advance_to(end);
    let health = projector.health(end);
    let mut summary = Summary::new(
        &trace,
        &recorder,
        &frame_us,
        &health,
        bench,
        started.elapsed(),
    );
    summary.boards = boards::boards(&projector);
    summary.buses = skin.buses();
    summary.faults = script.report();
    summary.taxels.list(&projector, end);
    let course = margins::Course {
        flows: &display.take_flows(),
        samples: &samples,
        totals: &totals,
        wires: projector.display().wires().len(),
    };
    let file = &setup.limits.value;
    summary.margins = margins::margins(&course, projector.guard().limits(), file);
    recorder.tell(&mut effort, projector.display().wires().len());
    effort.traffic = bank.traffic();
    effort.calibrated = setup.scene.value.compression.ki > 1;
    Ok(Outcome {
        warmth: samples.iter().map(margins::warmth).collect(),
        skin_limits: margins::skin_limits(file),
        trace,
        summary,
        frame_us,
        effort,
        failure,
        can: skin.take(),
        i2c,
        notes: Vec::new(),
    })
}

/// A live view of a run that ends at `end`; without a terminal it says so, and the run goes on without.
fn open_watch(
    setup: &Setup,
    seed: u64,
    projector: &Projector,
    end: Instant,
    virtual_time: bool,
) -> Result<Option<Watch>, Failure> {
    let header = header(setup, seed, projector)?;
    let opened = Watch::open(&header, projector.layout(), end, virtual_time);
    let opened = opened.map_err(|e| Failure::Device(format!("the live view: {e}")))?;
    if opened.is_none() {
        note(
            "--watch: standard input or output is no terminal; the run goes on without a live view",
        );
    }
    Ok(opened)
}

fn edge(e: &palpate_emulators::display::OutputEdge) -> Event {
    Event::Edge {
        t_ns: e.at.0,
        board: e.board,
        channel: e.channel,
        high: e.high,
    }
}

/// Thousandths of a degree; `None` for a display without wires.
fn milli_c(celsius: f64) -> Option<i32> {
    celsius.is_finite().then(|| (celsius * 1e3).round() as i32)
}
