//! Whole runs of scenes and recordings on an emulated bench: a pass that finds intensity levels, a pass that counts.

mod play;
mod shared;

use std::borrow::Cow;
use std::convert::Infallible;
use std::time::Duration as Elapsed;

use palpate_core::contact::Levels;
use palpate_core::driver::Actuators;
use palpate_core::guard::Guarded;
use palpate_core::projector::{FrameReport, LoopError, Observer};
use palpate_core::skin::{CanSkin, Layout};
use palpate_core::units::{Duration, Instant};
use palpate_emulators::sensor::can::faults::Faulty;
use palpate_emulators::sensor::rig::Handle;
use palpate_files::Setup;

use crate::failure::Failure;
use crate::levels::{Intensities, dynamic_levels, known_levels};
use crate::loops::made;
use crate::pass::{self, PassReport};
use crate::place::looking;
use crate::plan::Responses;
use crate::policy::TICK;
use crate::policy::refuse_hardware;
use crate::recorder::Truth;
use crate::replay::{CanPlayer, Rows};
use crate::skin_end::{SkinEnd, Tap};
use crate::tape::Tape;
use crate::{Host, Input, Keep, Outcome, plan, skin};

/// [`crate::run()`], keeping more, with a host that measures and looks on.
///
/// # Errors
/// As [`crate::run()`].
pub fn run_with(
    setup: &Setup,
    input: &Input,
    seed: u64,
    keep: Keep,
    host: &mut dyn Host,
) -> Result<Outcome, Failure> {
    refuse_hardware(&setup.bench.value)?;
    let (setup, report) = passed(setup, seed)?;
    let mut outcome = run_once(&setup, input, seed, keep, host)?;
    pass::tell(&mut outcome, &setup, report);
    Ok(outcome)
}

/// Passes the wires of an emulated bench that need it, in no time of those who look on. Returns the setup of what follows and,
/// where there was a pass, the report on it.
///
/// # Errors
/// The failures of [`run_with`].
pub fn passed(setup: &Setup, seed: u64) -> Result<(Cow<'_, Setup>, Option<PassReport>), Failure> {
    let play = |own: &Setup| run_once(own, &Input::Scene, seed, Keep::default(), &mut ());
    pass::before(setup, play)
}

/// Runs a setup whose wires are as it says.
fn run_once(
    setup: &Setup,
    input: &Input,
    seed: u64,
    keep: Keep,
    host: &mut dyn Host,
) -> Result<Outcome, Failure> {
    let layout = plan::layout(&setup.sensor.value)?;
    let responses = Responses::default();
    let run = Run {
        setup,
        layout: &layout,
        responses: &responses,
        seed,
        keep,
        waits: matches!(input, Input::Stream(_)),
        began: host.stopwatch().map(|read| read()),
    };
    let outcome = match input {
        Input::Scene => run.scene(host),
        Input::Rows(sources) => {
            let longest = sources.iter().map(|s| s.frames()).max().unwrap_or(0);
            let end = sources.iter().map(|s| s.span_us()).max().unwrap_or(0);
            let skin = || Rows::new(sources, &setup.sensor.value, &layout);
            run.replay(skin, longest, Instant::from_micros(end), host)
        }
        Input::Stream(rows) => {
            let levels = dynamic_levels(&setup.scene.value.compression);
            let mut skin = Rows::streamed(rows.as_ref(), &setup.sensor.value, &layout)?;
            let (skin, end) = (&mut skin, scene_end(setup));
            let ran = run.one(levels, skin, Truth::Unknown, end, host);
            // To the loop a wrong row is a lost bus.
            rows.wrong().map_or(ran, |error| Err(error.into()))
        }
        Input::Frames(frames) => {
            let skin = || {
                let player = CanPlayer::new(frames.frames()?);
                Ok(skin::source(setup, &layout, Tap::new(player, keep.can)))
            };
            run.replay(skin, frames.rows(), frames.end(), host)
        }
    };
    host.end();
    let replayed = !matches!(input, Input::Scene);
    Ok(outcome?.concluded(setup, replayed))
}

/// Actuators that drive nothing: for a pass that only looks at contacts.
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

/// Parameters that every pass of a run shares.
#[derive(Clone, Copy)]
struct Run<'a> {
    setup: &'a Setup,
    /// The whole skin's layout, also where this is one finger's part.
    layout: &'a Layout,
    responses: &'a Responses,
    seed: u64,
    keep: Keep,
    /// `true` where readings arrive during the run: frames are then not timed.
    waits: bool,
    /// Reading of the host's stopwatch at the run's begin.
    began: Option<Elapsed>,
}

impl Run<'_> {
    /// A scene's own touches on an emulated skin.
    fn scene(&self, host: &mut dyn Host) -> Result<Outcome, Failure> {
        let (setup, scene) = (self.setup, &self.setup.scene.value);
        let end = scene_end(setup);
        if skin::is_array(setup) {
            let skin = || skin::scene(setup, self.seed, None);
            let levels = self.calibrate(&mut skin()?, end, host)?;
            return self.count(levels, &mut skin()?, Truth::of_scene(setup), end, host);
        }
        let emulated = || skin::emulated(setup, self.layout, self.seed);
        let mut first = on_tape(setup, self.layout, emulated()?);
        let levels = self.calibrate(&mut first, end, host)?;
        let tape = &mut first.bus_mut().inner;
        // A run that is watched is played once, also where a tape turns out to be of no use.
        if scene.faults.is_empty() && tape.is_exact() && !host.looks_on() {
            tape.rewind(end);
            let tape = std::mem::replace(tape, Tape::new(emulated()?));
            let mut skin = skin::source(setup, self.layout, Tap::new(tape, self.keep.can));
            let played = &mut skin;
            let outcome = self.count(levels.clone(), played, Truth::of_scene(setup), end, host)?;
            if skin.bus().inner.is_exact() {
                return Ok(outcome);
            }
        }
        let faulty = Faulty::new(emulated()?, self.seed, "sensor bus");
        let mut skin = skin::source(setup, self.layout, Tap::new(faulty, self.keep.can));
        let skin = &mut skin;
        self.count(levels, skin, Truth::of_scene(setup), end, host)
    }

    /// A recording with `rows` rows that ends at `end`: one pass for levels, one that counts.
    fn replay<S: SkinEnd>(
        &self,
        skin: impl Fn() -> Result<S, Failure>,
        rows: usize,
        end: Instant,
        host: &mut dyn Host,
    ) -> Result<Outcome, Failure> {
        let first = skin()?;
        let reference = self.setup.scene.value.reference_frames;
        if rows <= reference as usize {
            return Err(Failure::Input(format!(
                "the recording: expected more than the {reference} reference rows, found {rows}"
            )));
        }
        let end = end + Duration::from_millis(100);
        let (levels, mut skin) = match known_levels(&self.setup.scene.value.compression) {
            Some(known) => (known, first),
            None => {
                let mut first = first;
                let levels = self.calibrate(&mut first, end, host)?;
                (levels, skin()?)
            }
        };
        let skin = &mut skin;
        self.count(levels, skin, Truth::Unknown, end, host)
    }

    /// A first pass that finds the levels.
    fn calibrate(
        &self,
        skin: &mut dyn SkinEnd,
        end: Instant,
        host: &mut dyn Host,
    ) -> Result<Levels, Failure> {
        let looking = (&*looking(self.setup), self.responses);
        calibrate(looking, self.seed, skin, end, host)
    }

    /// The pass that counts, on one display or on several.
    fn count(
        &self,
        levels: Levels,
        skin: &mut dyn SkinEnd,
        truth: Truth,
        end: Instant,
        host: &mut dyn Host,
    ) -> Result<Outcome, Failure> {
        match self.setup.fingers.is_empty() {
            true => self.one(levels, skin, truth, end, host),
            // A page draws one finger; the code that joins several would be a twentieth of its WebAssembly module.
            false if cfg!(target_family = "wasm") => Err(Failure::Input(format!(
                "bench `{}`: expected one display in a page; `hil run` has all of them",
                self.setup.bench.value.name
            ))),
            false => self.several(&levels, skin, &truth, end, host),
        }
    }
}

/// Share of a run that its first pass takes, where there are two.
const HALF: f64 = 0.5;

/// The part of a pass that is over at `now`.
pub(crate) fn part(now: Instant, end: Instant) -> f64 {
    now.as_micros() as f64 / end.as_micros().max(1) as f64
}

/// End of a scene.
pub fn scene_end(setup: &Setup) -> Instant {
    Instant::from_micros((setup.scene.value.length_s * 1e6).round() as u64)
}

/// A skin that is recorded while it is emulated.
fn on_tape(setup: &Setup, layout: &Layout, handle: Handle) -> CanSkin<Tap<Tape>> {
    skin::source(setup, layout, Tap::new(Tape::new(handle), false))
}

/// The static intensity levels of a scene's own touches on an emulated skin: what a run on hardware goes by, since
/// it cannot see its whole input beforehand.
///
/// # Errors
/// [`Failure`] for a scene that fits no emulated skin.
pub fn scene_levels(setup: &Setup, seed: u64) -> Result<Levels, Failure> {
    let layout = plan::layout(&setup.sensor.value)?;
    let mut skin = on_tape(setup, &layout, skin::emulated(setup, &layout, seed)?);
    let looking = (&*looking(setup), &Responses::default());
    let skin = &mut skin;
    calibrate(looking, seed, skin, scene_end(setup), &mut ())
}

impl Observer for Intensities {
    fn frame(&mut self, report: &FrameReport<'_>) {
        report.contacts.iter().for_each(|c| self.add(c));
    }
}

/// A first pass that finds the static intensity levels over the whole input, where the scene has such.
fn calibrate(
    (setup, responses): (&Setup, &Responses),
    seed: u64,
    skin: &mut dyn SkinEnd,
    end: Instant,
    host: &mut dyn Host,
) -> Result<Levels, Failure> {
    let compression = &setup.scene.value.compression;
    if let Some(known) = known_levels(compression) {
        return Ok(known);
    }
    let mut projector = made(
        setup,
        plan::untextured(setup, seed, Levels::Off, responses)?,
    )?;
    let mut intensities = Intensities::default();
    let mut now = Instant::ZERO;
    while now < end && !host.passed(HALF * part(now, end)) {
        skin.advance_to(now);
        let polled = projector.poll(now, skin, &mut Silence, &mut intensities);
        polled.map_err(|e| match e {
            LoopError::Sensor(e) => Failure::Device(format!("sensor bus: {e}")),
            LoopError::Scan(e) => Failure::Device(format!("skin: {e}")),
            LoopError::Actuator(never) => match never {},
        })?;
        now = projector.next().min(now + TICK);
    }
    Ok(intensities.levels(compression.ki as usize, compression.vectors))
}
