//! The loop: `poll(now, sensor bus, actuators)` in the manner of smoltcp's interface. Whoever owns time
//! calls it, at the latest when [`Projector::next`] says so; it never waits and never asks for the time.

mod output;
mod routes;
mod sensing;
mod strokes;
mod texture;
mod weave;

pub use crate::illusion::Target;
pub use output::{Output, OutputSettings};
pub use texture::{Carrier, TextureError, TexturePlan, TextureReport};

use alloc::boxed::Box;
use core::fmt;

use crate::bus::{Actuators, SensorBus};
use crate::contact::{Contact, Levels, Scope, Settings, SettingsError, Work};
pub use crate::guard::Cause;
use crate::guard::Guard;
use crate::illusion::{CalibrationError, Display, Map, Tracks};
use crate::schedule::{Entry, Timing};
use crate::skin::{
    Condition, FrameError, HealthSettings, HealthSummary, Initialiser, InitialiserError,
    InitialiserSettings, Layout, Monitor, RelativeFrame,
};
use crate::units::{Board, Duration, Instant};
use crate::wire::uskin::IdProfile;

use sensing::Sensing;
use texture::Sampler;

/// A frame that went through compression.
#[derive(Debug)]
pub struct FrameReport<'a> {
    /// End of the scan.
    pub at: Instant,
    /// Zero-based number of the driving module's scan; the reference scans count.
    pub number: u32,
    /// The relative frame: magnitudes, who is in contact.
    pub relative: &'a RelativeFrame,
    /// The contacts of all modules.
    pub contacts: &'a [Contact],
}

/// Who wants to know what happens. Every method has an empty default.
pub trait Observer {
    /// A frame was compressed.
    fn frame(&mut self, report: &FrameReport<'_>) {
        let _ = report;
    }
    /// The guard passed, changed or refused a stimulus.
    fn entry(&mut self, entry: &Entry) {
        let _ = entry;
    }
    /// An onset was projected for these targets.
    fn onset(&mut self, at: Instant, targets: &[Target]) {
        let _ = (at, targets);
    }
    /// A taxel's health changed; from now on an ill one is left out, a good one taken in again.
    fn taxel(&mut self, at: Instant, index: usize, condition: Condition) {
        let _ = (at, index, condition);
    }
    /// A window of texture ended.
    fn texture(&mut self, report: &TextureReport<'_>) {
        let _ = report;
    }
    /// A board was switched off whole.
    fn all_off(&mut self, at: Instant, board: Board, cause: Cause) {
        let _ = (at, board, cause);
    }
}

/// Nobody wants to know.
impl Observer for () {}

/// What the sensor half is built from.
#[derive(Debug)]
pub struct SensingPlan {
    /// The skin.
    pub layout: Layout,
    /// Silence that ends a scan: longer than between two frames of one, shorter than between two scans.
    pub gap: Duration,
    /// How its boards number their frames.
    pub profile: IdProfile,
    /// Reference, threshold, faulty taxels.
    pub initialiser: InitialiserSettings,
    /// Compression.
    pub compression: Settings,
    /// When a taxel counts as ill.
    pub health: HealthSettings,
}

/// What the loop is built from.
#[derive(Debug)]
pub struct Plan {
    /// The sensor half.
    pub sensing: SensingPlan,
    /// The module that drives the display.
    pub drives: u16,
    /// Sensor to display.
    pub map: Map,
    /// The display.
    pub display: Display,
    /// Stimuli.
    pub output: OutputSettings,
    /// The texture that is felt, if any.
    pub texture: Option<TexturePlan>,
    /// The guard.
    pub guard: Guard,
}

/// Why a plan is no loop.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum PlanError {
    /// The module that shall drive the display does not exist; how many there are.
    NoSuchModule(usize),
    /// The initialiser's settings.
    Initialiser(InitialiserError),
    /// The compression settings.
    Compression(SettingsError),
    /// A calibration that is not of this display's wires.
    Calibration(CalibrationError),
    /// A texture that does not fit the skin.
    Texture(TextureError),
}

impl fmt::Display for PlanError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NoSuchModule(n) => write!(f, "expected a driving module below {n}"),
            Self::Initialiser(e) => e.fmt(f),
            Self::Compression(e) => e.fmt(f),
            Self::Calibration(e) => write!(f, "expected {e}"),
            Self::Texture(e) => e.fmt(f),
        }
    }
}

impl core::error::Error for PlanError {}

impl From<SettingsError> for PlanError {
    fn from(e: SettingsError) -> Self {
        Self::Compression(e)
    }
}

impl From<TextureError> for PlanError {
    fn from(e: TextureError) -> Self {
        Self::Texture(e)
    }
}

impl From<InitialiserError> for PlanError {
    fn from(e: InitialiserError) -> Self {
        Self::Initialiser(e)
    }
}

/// An error of one of the buses; the outputs have been switched off, as far as the bus let us.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LoopError<S, A> {
    /// The sensor bus.
    Sensor(S),
    /// The actuator bus.
    Actuator(A),
}

/// The loop and all its memory.
#[derive(Debug)]
pub struct Projector {
    layout: Layout,
    sensing: Sensing,
    output: Output,
    map: Map,
    drives: u16,
    targets: Box<[Target]>,
    tracks: Tracks,
    /// Time of the frame that the tracks know.
    tracked: Option<Instant>,
}

impl Projector {
    /// Builds the loop; the last time that it allocates.
    ///
    /// # Errors
    /// [`PlanError`] for a plan that fits no hardware.
    pub fn new(plan: Plan) -> Result<Self, PlanError> {
        let modules = plan.sensing.layout.modules().len();
        if usize::from(plan.drives) >= modules {
            return Err(PlanError::NoSuchModule(modules));
        }
        if plan.output.calibration.len() != plan.display.wires().len() {
            return Err(PlanError::Calibration(CalibrationError::Count));
        }
        // No module has more contacts than taxels, whatever K_C says.
        let taxels = plan.sensing.layout.taxels();
        let most = usize::from(plan.sensing.compression.clusters).min(taxels);
        let step = match plan.output.smallest_step {
            part if part > 0.0 => part * plan.display.gap(),
            _ => 0.0,
        };
        let (mut sensing, layout) = Sensing::new(plan.sensing, plan.drives)?;
        let mut output = Output::new(plan.display, plan.output, plan.guard);
        if let Some(texture) = plan.texture {
            let (sampler, carrier) = Sampler::new(texture, &layout, output.timing().soa)?;
            sensing.sample(sampler);
            output.carry(carrier);
        }
        Ok(Self {
            layout,
            sensing,
            output,
            map: plan.map,
            drives: plan.drives,
            targets: alloc::vec![Target::default(); most].into(),
            tracks: Tracks::new(most, step),
            tracked: None,
        })
    }

    /// When the loop has to be called next, whatever comes in; earlier calls do no harm.
    pub fn next(&self) -> Instant {
        let output = self.output.next();
        let deadline = self.output.guard().deadline();
        deadline.map_or(output, |deadline| deadline.min(output))
    }

    /// Does all that is due at `now`: takes every frame that has come, ends what has ended, projects the
    /// newest contacts when an onset is due. Returns whether an onset was.
    ///
    /// # Errors
    /// The first error of a bus, after switching everything off.
    pub fn poll<S: SensorBus, A: Actuators>(
        &mut self,
        now: Instant,
        sensors: &mut S,
        actuators: &mut A,
        observer: &mut impl Observer,
    ) -> Result<bool, LoopError<S::Error, A::Error>> {
        loop {
            match sensors.receive() {
                Ok(Some(received)) => self.sensing.take(&received, &self.layout, observer),
                Ok(None) => break,
                Err(e) => {
                    let off = self.all_off(now, Cause::SensorError, actuators, observer);
                    return Err(off.map_or_else(LoopError::Actuator, |()| LoopError::Sensor(e)));
                }
            }
        }
        self.sensing.flush(now, &self.layout, observer);
        let guard = self.output.guard_mut();
        if let Some(at) = self.sensing.last_received() {
            guard.hear(at);
        }
        let stale = guard.is_stale(now);
        if let Some(cause) = guard.watch(now) {
            self.all_off(now, cause, actuators, observer)
                .map_err(LoopError::Actuator)?;
        }
        self.track();
        let due = self.output.is_due(now) && !stale;
        let count = if due { self.aim(now) } else { 0 };
        let texture = self.sensing.texture(now).filter(|_| !stale);
        let targets = &self.targets[..count];
        match self
            .output
            .poll(now, targets, texture.as_ref(), actuators, observer)
        {
            Ok(onset) => Ok(onset),
            Err(e) => {
                // The first error is the one to tell; what the way out adds cannot be told apart.
                let _ = self.all_off(now, Cause::ActuatorError, actuators, observer);
                Err(LoopError::Actuator(e))
            }
        }
    }

    /// Everything off, now, and kept off until [`Self::reset`].
    ///
    /// # Errors
    /// The first board that did not answer.
    pub fn all_off<A: Actuators>(
        &mut self,
        now: Instant,
        cause: Cause,
        actuators: &mut A,
        observer: &mut impl Observer,
    ) -> Result<(), A::Error> {
        self.output.all_off(now, cause, actuators, observer)
    }

    /// The way back from a stop: nothing is driven after [`Self::all_off`], whatever its cause, until this has
    /// been called once the cause is gone. Sensor frames come, the loop was called on time, and all outputs
    /// take an all-off.
    ///
    /// # Errors
    /// What is still wrong; everything stays off.
    pub fn reset<A: Actuators>(&mut self, now: Instant, actuators: &mut A) -> Result<(), Cause> {
        self.output.reset(now, actuators)
    }

    /// The newest contacts that drive the display: with K_C over the whole skin all of them, else one
    /// module's.
    fn ours(sensing: &Sensing, drives: u16) -> impl Iterator<Item = &Contact> {
        let compressor = sensing.compressor();
        let whole = compressor.settings().scope == Scope::Skin;
        let contacts = compressor.contacts().iter();
        contacts.filter(move |c| whole || c.module == drives)
    }

    /// Takes the contacts of a frame that has not been taken yet.
    fn track(&mut self) {
        let newest = self.sensing.newest_frame();
        if let Some(at) = newest.filter(|_| newest != self.tracked) {
            self.tracked = newest;
            let placed = |c: &Contact| (c.id, self.map.apply(c.place));
            self.tracks
                .observe(at, Self::ours(&self.sensing, self.drives).map(placed));
        }
    }

    /// Where the newest contacts are on the display at `now`; returns how many there are.
    fn aim(&mut self, now: Instant) -> usize {
        let levels = match &self.sensing.compressor().settings().levels {
            Levels::Off => 1,
            Levels::Table(table) => u16::try_from(table.values().len()).unwrap_or(u16::MAX),
            Levels::Dynamic(k) => *k,
        };
        let drive = self.output.drive();
        let mut count = 0;
        for (target, contact) in self
            .targets
            .iter_mut()
            .zip(Self::ours(&self.sensing, self.drives))
        {
            let tracked = self.tracks.place(contact.id, now);
            *target = Target {
                place: tracked.unwrap_or(self.map.apply(contact.place)),
                weight: drive.weight(contact.level, levels),
            };
            count += 1;
        }
        count
    }

    /// Stimulus duration and onset asynchrony in force.
    pub const fn timing(&self) -> Timing {
        self.output.timing()
    }

    /// The display.
    pub const fn display(&self) -> &Display {
        self.output.display()
    }

    /// The guard.
    pub const fn guard(&self) -> &Guard {
        self.output.guard()
    }

    /// The sensor-to-display map.
    pub const fn map(&self) -> &Map {
        &self.map
    }

    /// Health of the skin at `now`. Sorts, so it belongs after the loop, not in it.
    pub fn health(&mut self, now: Instant) -> HealthSummary {
        self.sensing.monitor_mut().summary(now)
    }

    /// What the skin is made of.
    pub const fn layout(&self) -> &Layout {
        &self.layout
    }

    /// Every taxel's rate and condition.
    pub const fn monitor(&self) -> &Monitor {
        self.sensing.monitor()
    }

    /// Reference, threshold and faulty taxels.
    pub const fn initialiser(&self) -> &Initialiser {
        self.sensing.initialiser()
    }

    /// Pulses of a texture that were left out for a wire to rest: dense ones meet the guard's burst row.
    pub fn rested_pulses(&self) -> u64 {
        self.output.rested()
    }

    /// What compression did and could leave out.
    pub fn work(&self) -> Work {
        self.sensing.compressor().work()
    }

    /// Frames that were no sensor data of this layout.
    pub const fn foreign_frames(&self) -> u64 {
        self.sensing.foreign()
    }

    /// Readings missing from the scans so far.
    pub fn lost_readings(&self) -> u64 {
        self.sensing.lost()
    }

    /// Readings missing from one module's scans so far.
    pub fn lost_readings_of(&self, module: usize) -> u64 {
        self.sensing.lost_of(module)
    }

    /// The last frame that compression refused, if any.
    pub const fn refused_frame(&self) -> Option<&FrameError> {
        self.sensing.refused()
    }
}
