//! A run: a scene or a recording through the loop onto an emulated display, in virtual time; or the loop on
//! a [real] bench, held to the wall clock.

mod boards;
mod effects;
pub mod effort;
pub(crate) mod ends;
mod feel;
mod margins;
mod pass;
pub mod real;
mod recorder;
mod replay;
pub(crate) mod script;
mod scripted;
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
use palpate_core::guard::Guarded;
use palpate_core::projector::{LoopError, Plan, Projector};
use palpate_core::units::{Duration, Instant};
use palpate_emulators::can::faults::Faulty;
use palpate_records::i2c::Transfer;
use palpate_records::report::{SkinLimits, Warmth};
use palpate_records::trace::Trace;

use crate::clock;
use crate::failure::Failure;
use crate::output::note;
use crate::plan;
use crate::watch::Watch;
use palpate_files::Setup;

use effort::Effort;
use ends::header;
use pass::project;
use recorder::Recorder;
use replay::Replay;
use sensor::{Skin, Tapped};
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
            let skin = || skin::emulated(setup, &layout, seed);
            let mut tape = Tape::new(skin()?);
            let levels = calibrate(setup, seed, &mut tape, end)?;
            let truth = || Some((scene.touches.clone(), scene.drives));
            // What is watched is played once, also where a tape turns out to be of no use.
            if scene.faults.is_empty() && tape.is_exact() && !keep.watch {
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
    let mut skin = Tape::new(skin::emulated(setup, &layout, seed)?);
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
    let mut projector = made(setup, plan::untextured(setup, seed, Levels::Off)?)?;
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
    made(setup, plan::plan(setup, seed, levels)?)
}

fn made(setup: &Setup, plan: Plan) -> Result<Projector, Failure> {
    Projector::new(plan).map_err(|e| Failure::Input(format!("{}: {e}", setup.scene.source.label())))
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
