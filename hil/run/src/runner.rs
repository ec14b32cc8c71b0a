//! Whole runs of scenes and recordings on an emulated bench: a pass that finds intensity levels, a pass that counts.

mod several;

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
use palpate_records::felt::FeltPath;
use palpate_records::margin::sort;
use palpate_records::readings::Readings;
use palpate_records::trace::{Header, Ledger};

use crate::actuator_bus::ActuatorBus;
use crate::display_end::{DisplayEnd, EmulatedDisplay};
use crate::effort::Effort;
use crate::failure::Failure;
use crate::header::header;
use crate::levels::{Intensities, dynamic_levels, known_levels};
use crate::loops::{build_with, made};
use crate::piece::Pieces;
use crate::place::{Place, looking};
use crate::plan::Responses;
use crate::policy::{Policy, refuse_hardware};
use crate::recorder::{Recorder, Truth, milli_c};
use crate::replay::{CanPlayer, Rows};
use crate::session::{Session, TICK, Turn};
use crate::skin_end::{SkinEnd, Tap};
use crate::summary::{AskedLevel, finished};
use crate::tape::Tape;
use crate::verdict::STOPPED_BY;
use crate::{
    Beginning, BusReport, Host, Input, Keep, KeptReadings, Outcome, TurnView, margins, plan, skin,
};

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
            let ran = run.project(levels, skin, Truth::Unknown, end, host);
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
    }?;
    let replayed = !matches!(input, Input::Scene);
    Ok(outcome.concluded(setup, replayed))
}

/// Nothing is driven: for a pass that only looks at contacts.
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

/// What every pass of a run shares.
#[derive(Clone, Copy)]
struct Run<'a> {
    setup: &'a Setup,
    layout: &'a Layout,
    responses: &'a Responses,
    seed: u64,
    keep: Keep,
    /// Whether its readings come meanwhile.
    waits: bool,
    /// When it began, by the host's stopwatch.
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
            return self.count(levels, &mut skin()?, Truth::of(setup), end, host);
        }
        let emulated = || skin::emulated(setup, self.layout, self.seed);
        let mut first = on_tape(setup, self.layout, emulated()?);
        let levels = self.calibrate(&mut first, end, host)?;
        let tape = &mut first.bus_mut().inner;
        // What is watched is played once, also where a tape turns out to be of no use.
        if scene.faults.is_empty() && tape.is_exact() && !host.looks_on() {
            tape.rewind(end);
            let tape = std::mem::replace(tape, Tape::new(emulated()?));
            let mut skin = skin::source(setup, self.layout, Tap::new(tape, self.keep.can));
            let played = &mut skin;
            let outcome = self.count(levels.clone(), played, Truth::of(setup), end, host)?;
            if skin.bus().inner.is_exact() {
                return Ok(outcome);
            }
        }
        let faulty = Faulty::new(emulated()?, self.seed, "sensor bus");
        let mut skin = skin::source(setup, self.layout, Tap::new(faulty, self.keep.can));
        let skin = &mut skin;
        self.count(levels, skin, Truth::of(setup), end, host)
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
            true => self.project(levels, skin, truth, end, host),
            // A page draws one finger, and what joins several is a twentieth of its module.
            false if cfg!(target_family = "wasm") => Err(Failure::Input(format!(
                "bench `{}`: expected one display in a page; `hil run` has all of them",
                self.setup.bench.value.name
            ))),
            false => self.several(&levels, skin, &truth, end, host),
        }
    }

    /// The loop between a skin and an emulated display that has not begun.
    fn assemble<S: SkinEnd>(
        &self,
        levels: Levels,
        skin: S,
        truth: Truth,
        place: (Place, Option<&ActuatorBus>),
        host: &dyn Host,
    ) -> Result<(Header, Session<S, EmulatedDisplay>), Failure> {
        let projector = build_with(self.setup, self.seed, levels, self.responses)?;
        let mut display = EmulatedDisplay::at(self.setup, place, &projector, self.seed)?;
        display.keep(self.keep)?;
        let mut recorder = Recorder::new(truth, projector.layout());
        recorder.joints.clone_from(&self.setup.scene.value.joints);
        recorder.counts = host.looks_on().then(Vec::new);
        let drives = self.setup.scene.value.drives;
        let streams = self.keep.summary && host.records();
        recorder.handed = streams.then(Vec::new);
        recorder.taxels = (streams && self.keep.readings == KeptReadings::All)
            .then(|| Readings::whole(projector.layout(), drives));
        recorder.readings = match self.keep.readings {
            KeptReadings::None => None,
            _ if streams => None,
            KeptReadings::Sampled => Some(Readings::sampled(projector.layout(), drives)),
            KeptReadings::All => Some(Readings::whole(projector.layout(), drives)),
        };
        let header = header(self.setup, self.seed, &projector)?;
        recorder.felt = self.keep.summary.then(|| FeltPath::new(&header));
        if self.keep.band {
            display.compare(self.setup, &header, true)?;
        }
        let ends = (skin, display);
        let policy = Policy::emulated(self.setup.bench.value.unit.is_some());
        // Of a stream's frames the wait for their readings would be timed as well.
        let watch = host.stopwatch().filter(|_| !self.waits);
        let mut session = Session::new(projector, ends, policy, recorder, watch);
        session.thin_costs(self.keep.summary);
        Ok((header, session))
    }

    /// The loop between the skin and the emulated display until `end`.
    fn project(
        &self,
        levels: Levels,
        skin: &mut dyn SkinEnd,
        truth: Truth,
        end: Instant,
        host: &mut dyn Host,
    ) -> Result<Outcome, Failure> {
        let place = Place::whole(&self.setup.bench.value);
        let (header, mut session) = self.assemble(levels, skin, truth, (place, None), host)?;
        let mut pieces = Pieces::new(header.soa_us);
        host.begin(&Beginning {
            setup: self.setup,
            header: &header,
            projector: session.projector(),
            end,
            display: None,
        })?;
        // The policy waits for boards that do not answer, so this cannot fail.
        let mut next = session.start(Instant::ZERO).unwrap_or_default();
        let mut last = end;
        let calibrated = known_levels(&self.setup.scene.value.compression).is_none();
        let behind = |now| match calibrated {
            true => HALF + HALF * part(now, end),
            false => part(now, end),
        };
        while next < end {
            let now = next;
            let turn = session.turn(now)?;
            if let Some(piece) = pieces.take(&mut session, false) {
                host.record(piece)?;
            }
            let is_stopped =
                turn != Turn::Last && look_on(&session, (now, 0), session.seen().0, host);
            if is_stopped {
                let text = format!("{STOPPED_BY}the person who watched");
                session.recorder().note(now, text);
            }
            match turn {
                Turn::Next(then) if !is_stopped && !host.passed(behind(now)) => next = then,
                Turn::Next(_) | Turn::Last => {
                    last = now;
                    break;
                }
            }
        }
        host.end();
        session.conclude(last);
        let (display, projector, recorder) = session.all();
        display.settle(last, projector, recorder)?;
        if let Some(piece) = pieces.take(&mut session, true) {
            host.record(piece)?;
        }
        self.outcome(header, &mut session, last, host)
    }

    /// What the run came to.
    fn outcome<S: SkinEnd>(
        &self,
        header: Header,
        session: &mut Session<S, EmulatedDisplay>,
        end: Instant,
        host: &dyn Host,
    ) -> Result<Outcome, Failure> {
        let setup = self.setup;
        let costs = session.take_costs();
        let failure = session.take_failure();
        session.skin().advance_to(end);
        let can = session.skin().take_frames();
        let mut effort = Effort::of(&costs, session.traffic());
        effort.calibrated = known_levels(&setup.scene.value.compression).is_none();
        let bench = &setup.bench.value;
        let (display, projector, _) = session.all();
        let (samples, currents) = display.take_samples();
        let totals = display.hardware().totals();
        let course = margins::Course {
            currents: &currents,
            samples: &samples,
            totals: &totals,
        };
        let limits = projector.guard().limits();
        let mut margins = margins::margins(&course, limits);
        margins.extend(display.heat_margins());
        sort(&mut margins);
        let ledger = Ledger {
            energy_uj: (totals.electrical_j * 1e6).round() as u64,
            hottest_wire: milli_c(totals.hottest_wire.0).map(|t| (t, totals.hottest_wire.1 as u16)),
            margins,
            length_us: end.as_micros(),
            ..Ledger::default()
        };
        let (trace, mut summary) = finished(session, header, ledger, &costs, bench);
        if let Some(texture) = &mut summary.texture {
            texture.compared(setup)?;
        }
        summary.buses = session.skin().buses();
        if let (Some(read), Some(began)) = (host.stopwatch(), self.began) {
            summary.wall_s = read().saturating_sub(began).as_secs_f64();
        }
        let (display, projector, recorder) = session.all();
        effort.finish(projector, recorder);
        summary.faults = display.faults();
        summary.unit = display.unit();
        summary.heat = display.heat();
        summary.felt.asked = AskedLevel::of(&setup.scene.value, projector);
        if summary.felt.level_db.is_some_and(|l| l.median < 0.0) {
            let missing = -plan::strongest(setup, projector)?;
            summary.felt.missing_db = Some(missing).filter(|db| *db > 0.0);
        }
        summary.felt.band = display.band(summary.path_error_mm.is_some());
        Ok(Outcome {
            readings: recorder.readings.take(),
            warmth: samples.iter().map(margins::warmth).collect(),
            i2c: display.transfers(),
            trace,
            summary,
            frame_us: costs.iter().map(|c| c.us).collect(),
            effort,
            failure,
            can,
            notes: Vec::new(),
            displays: Vec::new(),
        })
    }
}

impl<S: SkinEnd, D: DisplayEnd> Session<S, D> {
    /// Shows the turn of a display at a time, with the lines of its sensor buses. Returns the answer of `to`.
    pub fn show<T>(
        &self,
        (now, display): (Instant, usize),
        buses: &dyn Fn() -> Vec<String>,
        to: impl FnOnce(&TurnView<'_>) -> T,
    ) -> T {
        let (_, recorder, look) = self.look();
        to(&TurnView {
            now,
            display,
            events: &recorder.events,
            counts: recorder.counts.as_deref().unwrap_or_default(),
            buses,
            state: &|wants| look.state(wants),
        })
    }
}

/// Shows a turn to a host that looks on. Returns whether the host wants no more.
fn look_on<S: SkinEnd>(
    session: &Session<S, EmulatedDisplay>,
    turn: (Instant, usize),
    skin: &dyn SkinEnd,
    host: &mut dyn Host,
) -> bool {
    let buses = || -> Vec<String> { skin.buses().iter().map(BusReport::words).collect() };
    host.looks_on() && session.show(turn, &buses, |seen| host.turn(seen))
}

/// The part of a run that its first pass is, where there are two.
const HALF: f64 = 0.5;

/// The part of a pass that is over at `now`.
pub(crate) fn part(now: Instant, end: Instant) -> f64 {
    now.as_micros() as f64 / end.as_micros().max(1) as f64
}

/// When a scene ends.
pub(crate) fn scene_end(setup: &Setup) -> Instant {
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
        report.contacts.iter().for_each(|c| self.add(c.intensity));
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
    // Without a table nothing was touched.
    let table = intensities.table(compression.ki as usize);
    Ok(table.map_or(Levels::Off, Levels::Table))
}
