//! The loop: `poll(now, skin, actuators)` in the manner of smoltcp's interface. The owner of time
//! calls it, at the latest when [`Projector::next`] says so; it never waits and never asks for the time.

mod builder;
mod gather;
mod grid;
mod held;
mod hot;
mod output;
mod pass;
mod plan_error;
mod sensing;
mod stop;
mod strokes;
mod tap;
mod texture;
mod textured;
mod update;
mod view;
mod warm;
mod weave;

pub use crate::illusion::Target;
pub use builder::{Builder, OutputBuilder, sensor_area};
pub use held::ForeignContacts;
pub use output::{Output, OutputSettings};
pub use pass::{HotPass, Passing};
pub use plan_error::PlanError;
pub use tap::{Firmness, Taps};
pub use texture::{Carrier, TextureError, TexturePlan, TextureReport};
pub use update::Update;
pub use view::{View, Window};

use alloc::boxed::Box;

use crate::contact::{Contact, Levels, Scope, Settings, Work};
use crate::driver::Actuators;
pub use crate::guard::Cause;
use crate::guard::Guard;
use crate::illusion::{CalibrationError, Display, Tracks};
use crate::render::Renderer;
use crate::schedule::{Entry, Timing};
use crate::skin::{
    Baseline, BaselineSettings, Condition, HealthSettings, HealthSummary, Layout, ModuleScan,
    Monitor, RelativeFrame, ScanError, SkinSource,
};
use crate::units::{Board, Duration, Instant, Ticks};

use sensing::Sensing;
use texture::Sampler;
use weave::Texture;

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

/// Observer of the loop's events. Every method has an empty default.
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
    /// The guard would have switched everything off, and only looks on.
    fn observed_stop(&mut self, at: Instant, cause: Cause) {
        let _ = (at, cause);
    }
}

/// An observer that keeps nothing.
impl Observer for () {}

/// Parts from which the sensor half is built.
#[derive(Debug)]
pub struct SensingPlan {
    /// The skin.
    pub layout: Layout,
    /// Reference, threshold, faulty taxels.
    pub baseline: BaselineSettings,
    /// Compression.
    pub compression: Settings,
    /// Rules by which a taxel counts as ill.
    pub health: HealthSettings,
}

/// Parts from which the loop is built.
#[derive(Debug)]
pub struct Plan {
    /// The sensor half.
    pub sensing: SensingPlan,
    /// The module that drives the display.
    pub drives: u16,
    /// View of the skin on the display.
    pub view: View,
    /// Longest time for which a contact is carried on with its velocity to the instant of an onset; zero leaves it where its
    /// newest frame had it.
    pub ahead: Duration,
    /// The display.
    pub display: Display,
    /// Settings of stimuli.
    pub output: OutputSettings,
    /// The texture that is felt, if any.
    pub texture: Option<TexturePlan>,
    /// The guard.
    pub guard: Guard,
}

/// An error of one of the two ends; the outputs have been switched off, as far as the driver allowed it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum LoopError<S, A> {
    /// An error of the skin.
    #[error("skin: {0}")]
    Sensor(S),
    /// A scan of the skin that is not of the loop's layout.
    #[error("skin: {0}")]
    Scan(ScanError),
    /// An error of the driver.
    #[error("actuators: {0}")]
    Actuator(A),
}

/// Reasons for which the reference was not taken anew as asked.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum RezeroError<A> {
    /// Something is in contact, or seems to be.
    #[error(
        "expected a skin that nothing touches, found a contact; lift the touch, or force it where there is none"
    )]
    Touched,
    /// The driver did not switch everything off.
    #[error("actuators: {0}")]
    Actuator(A),
    /// Everything stays off for another cause.
    #[error("everything stays off: {0}")]
    Off(Cause),
}

/// The loop and all its memory.
#[derive(Debug)]
pub struct Projector {
    layout: Layout,
    sensing: Sensing,
    output: Output,
    view: View,
    drives: u16,
    targets: Box<[Target]>,
    tracks: Tracks,
    /// Time of the frame that the tracks know.
    tracked: Option<Instant>,
    /// Likely delay of held contacts after their time; zero for scans.
    later: Duration,
}

impl Projector {
    /// Builds the loop from everything there is to state; the last time that it allocates.
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
        let most = usize::from(plan.sensing.compression.most_clusters()).min(taxels);
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
            view: plan.view,
            drives: plan.drives,
            targets: alloc::vec![Target::default(); most].into(),
            tracks: Tracks::new(most, plan.ahead),
            tracked: None,
            later: Duration::ZERO,
        })
    }

    /// Time at which the loop has to be called next, whatever comes in; earlier calls do no harm.
    pub fn next(&self) -> Instant {
        self.output.next()
    }

    /// Does all that is due at `now`: takes every scan that has come, projects the newest contacts when an onset is
    /// due, ends what has ended. Returns whether an onset was. The guard stops or only looks on as in [`Output::turn`].
    ///
    /// # Errors
    /// The first error of an end, after switching everything off.
    pub fn poll<S: SkinSource + ?Sized, U: Update, A: Actuators<U> + ?Sized>(
        &mut self,
        now: Instant,
        skin: &mut S,
        actuators: &mut A,
        observer: &mut impl Observer,
    ) -> Result<bool, LoopError<S::Error, A::Error>> {
        let mut taken = Ok(());
        let read = skin.scans(now, &mut |scan| {
            if taken.is_ok() {
                taken = self.push(scan, observer);
            }
        });
        let read = read.map_err(LoopError::Sensor);
        if let Err(error) = read.and(taken.map_err(LoopError::Scan)) {
            let off = self.all_off(now, Cause::SensorError, actuators, observer);
            return Err(off.map_or_else(LoopError::Actuator, |()| error));
        }
        self.turn(now, actuators, observer)
            .map_err(LoopError::Actuator)
    }

    /// Takes one module's scan, from wherever it comes. [`Self::turn`] then does what it makes due.
    ///
    /// # Errors
    /// A scan that is not of the loop's layout; nothing has changed then.
    pub fn push(
        &mut self,
        scan: &ModuleScan<'_>,
        observer: &mut impl Observer,
    ) -> Result<(), ScanError> {
        self.sensing.take(scan, &self.layout, observer)
    }

    /// Tells whether K_C follows the number of touches that [`Self::touched`] is given.
    pub fn follows_touches(&self) -> bool {
        let settings = self.sensing.compressor().settings();
        settings.growth > settings.clusters
    }

    /// Sets K_C to the number of things that touch, from the next frame on and as far as the settings allow.
    pub fn touched(&mut self, count: usize) {
        self.sensing.allow(count);
    }

    /// Does all that is due at `now`, as [`Self::poll`], once the scans that have come are pushed.
    ///
    /// # Errors
    /// The driver's first error, after switching everything off.
    pub fn turn<U: Update, A: Actuators<U> + ?Sized>(
        &mut self,
        now: Instant,
        actuators: &mut A,
        observer: &mut impl Observer,
    ) -> Result<bool, A::Error> {
        self.sensing.look_round(now, &self.layout, observer);
        if let Some(at) = self.sensing.last_received() {
            self.output.hear(at);
        }
        self.track();
        let takes = self.output.takes_targets(now);
        let count = if takes { self.aim(now) } else { 0 };
        let tap = self.sensing.take_tap();
        tap.into_iter().for_each(|hard| self.output.tap(now, hard));
        let texture = self.sensing.texture(now);
        let targets = &self.targets[..count];
        self.output
            .turn(now, targets, texture.as_ref(), actuators, observer)
    }

    /// Switches everything off, now, and keeps it off until [`Self::reset`].
    ///
    /// # Errors
    /// Error of the first board that did not answer.
    pub fn all_off<U: Update, A: Actuators<U> + ?Sized>(
        &mut self,
        now: Instant,
        cause: Cause,
        actuators: &mut A,
        observer: &mut impl Observer,
    ) -> Result<(), A::Error> {
        self.output.all_off(now, cause, actuators, observer)
    }

    /// Resets the loop after a stop: nothing is driven after [`Self::all_off`], whatever its cause, until this has been
    /// called once the cause is gone. Sensor frames come, the loop was called on time, and all outputs take an all-off.
    ///
    /// # Errors
    /// [`Cause`] that still stands; everything stays off.
    pub fn reset<U: Update, A: Actuators<U> + ?Sized>(
        &mut self,
        now: Instant,
        actuators: &mut A,
        observer: &mut impl Observer,
    ) -> Result<(), Cause> {
        self.output.reset(now, actuators, observer)
    }

    /// Takes the reference of the whole skin anew from the next scans on, which are to be of a skin at rest. Stimuli stop
    /// first, with [`Cause::Rezero`]; none follows until there is a reference again. Refused while anything is in contact,
    /// unless `forced`.
    ///
    /// # Errors
    /// [`RezeroError::Touched`], and then nothing has changed. After any other error the reference is taken anew, and
    /// everything stays off until [`Self::reset`].
    pub fn rezero<U: Update, A: Actuators<U> + ?Sized>(
        &mut self,
        now: Instant,
        forced: bool,
        actuators: &mut A,
        observer: &mut impl Observer,
    ) -> Result<(), RezeroError<A::Error>> {
        if self.sensing.is_touched() && !forced {
            return Err(RezeroError::Touched);
        }
        let stopped = self.guard().latched();
        let off = self.all_off(now, Cause::Rezero, actuators, observer);
        self.sensing.rezero();
        off.map_err(RezeroError::Actuator)?;
        match stopped {
            // Another cause keeps everything off.
            Some(_) => Ok(()),
            None => self
                .reset(now, actuators, observer)
                .map_err(RezeroError::Off),
        }
    }

    /// Calls [`Output::settle`].
    pub fn settle(&mut self, at: Instant, observer: &mut impl Observer) -> bool {
        self.output.settle(at, observer)
    }

    /// Accounts for a sleep of the machine, as [`Output::slept`] does.
    pub fn slept(&mut self, now: Instant, span: Duration) {
        self.output.slept(now, span);
    }

    /// Counts what is not known to be off as on until `at`, as [`Output::still_on`] does.
    pub fn still_on(&mut self, at: Instant) {
        self.output.still_on(at);
    }

    /// The newest contacts that drive the display: with K_C over the whole skin all of them, else one module's.
    fn ours(sensing: &Sensing, drives: u16) -> impl Iterator<Item = &Contact> + Clone {
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
            if self.view.frame(Self::ours(&self.sensing, self.drives)) {
                // Places before the window moved are no way that a contact went.
                self.tracks.clear();
            }
            let shown = Self::ours(&self.sensing, self.drives);
            let shown = shown.filter_map(|c| Some((c.id, self.view.place(c)?)));
            self.tracks.observe(at, shown);
        }
    }

    /// Writes the places of the newest contacts on the display at `now` into the targets; returns their number.
    fn aim(&mut self, now: Instant) -> usize {
        let ours = || Self::ours(&self.sensing, self.drives);
        let settings = &self.sensing.compressor().settings().levels;
        let levels = settings.count();
        // A frame may have fewer contacts than levels found anew; its strongest gets the top level.
        let is_dynamic = matches!(settings, Levels::Dynamic(_));
        let top = is_dynamic.then(|| ours().map(|c| c.level).max()).flatten();
        let above = levels.saturating_sub(top.unwrap_or(levels));
        let drive = self.output.drive();
        let mut count = 0;
        let shown = ours().filter_map(|c| Some((c, self.view.place(c)?)));
        for (target, (contact, place)) in self.targets.iter_mut().zip(shown) {
            let place = self
                .tracks
                .place(contact.id, now - self.later)
                .unwrap_or(place);
            let weight = drive.weight(contact.level.saturating_add(above), levels);
            *target = Target { place, weight };
            count += 1;
        }
        count
    }

    /// Stimulus duration and onset asynchrony in force.
    pub const fn timing(&self) -> Timing {
        self.output.timing()
    }

    /// Pulse width of one wire for a contact on it with this weight, as in [`Output::width`].
    pub fn width(&self, weight: f32) -> Ticks {
        self.output.width(weight)
    }

    /// The display.
    pub const fn display(&self) -> &Display {
        self.output.display()
    }

    /// Renderer of contacts, where the law chooses their pulses, as in [`Output::renderer`].
    pub const fn renderer(&self) -> Option<&Renderer> {
        self.output.renderer()
    }

    /// The guard.
    pub const fn guard(&self) -> &Guard {
        self.output.guard()
    }

    /// Health of the skin up to `now`; a taxel counts by the worst that was found of it. Sorts, so it belongs after the loop, not in it.
    pub fn health(&mut self, now: Instant) -> HealthSummary {
        self.sensing.health(now)
    }

    /// Layout of the skin.
    pub const fn layout(&self) -> &Layout {
        &self.layout
    }

    /// Every taxel's rate and condition.
    pub const fn monitor(&self) -> &Monitor {
        self.sensing.monitor()
    }

    /// Reference, threshold and faulty taxels.
    pub const fn baseline(&self) -> &Baseline {
        self.sensing.baseline()
    }

    /// Taps of surfaces that were met or left.
    pub fn taps(&self) -> u64 {
        self.output.texture().map_or(0, Texture::tapped)
    }

    /// Pulses of a texture that were left out for a wire to rest: dense ones meet the guard's burst row.
    pub fn rested_pulses(&self) -> u64 {
        self.output.texture().map_or(0, Texture::rested)
    }

    /// Work of compression, done and left out.
    pub fn work(&self) -> Work {
        self.sensing.compressor().work()
    }
}
