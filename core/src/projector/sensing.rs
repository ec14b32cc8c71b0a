//! The sensor's half of the loop: scans of modules become frames of the skin, frames become contacts.
//!
//! A frame is a scan of the driving module; the other modules contribute their newest readings.

use crate::contact::{Compressor, Contact, Scope};
use crate::skin::{Baseline, HealthSummary, Layout, ModuleScan, Monitor, Scan, ScanError, Sense};
use crate::texture::Control;
use crate::units::{Duration, Instant};

use super::texture::Sampler;
use super::{FrameReport, Observer, PlanError, SensingPlan};

/// Time between looks for taxels that send nothing.
const ROUND: Duration = Duration::from_millis(100);

/// Everything behind the scan, so that it can be handed on while it is borrowed.
#[derive(Debug)]
struct Pipeline {
    sense: Sense,
    compressor: Compressor,
    texture: Option<Sampler>,
    drives: u16,
    frames: u32,
    /// Time of the newest frame that was compressed.
    newest: Option<Instant>,
}

/// The state of the sensor half.
#[derive(Debug)]
pub(super) struct Sensing {
    scan: Scan,
    pipeline: Pipeline,
    /// `true` where every module drives the display, `false` where one does.
    whole: bool,
    /// Reception of the newest scan that drives the display.
    last_received: Option<Instant>,
    /// Time of the next look for taxels that send nothing.
    next_round: Instant,
}

impl Pipeline {
    fn frame(&mut self, scan: &Scan, module: u16, layout: &Layout, observer: &mut impl Observer) {
        let at = scan.at();
        let report = &mut |i, condition| observer.taxel(at, i, condition);
        self.sense.watch(scan, usize::from(module), layout, report);
        if let Some(texture) = &mut self.texture {
            // As the last frame has it: a scan's own touch is known one frame later.
            let touched = self.sense.relative().contacts_of(usize::from(module));
            let touch = (module, !touched.is_empty());
            texture.scan(scan, touch, self.sense.baseline(), observer);
        }
        if module != self.drives {
            return;
        }
        let number = self.frames;
        self.frames = self.frames.saturating_add(1);
        let compressed = self.sense.frame(scan).and_then(|news| {
            if news.is_some_and(|news| news || !self.compressor.repeat()) {
                self.compressor.compress(self.sense.relative())?;
            }
            Ok(news.is_some())
        });
        // Only a frame of another layout is refused, and all of these are the loop's own.
        if compressed == Ok(true) {
            self.newest = Some(at);
            observer.frame(&FrameReport {
                at,
                number,
                relative: self.sense.relative(),
                contacts: self.compressor.contacts(),
            });
        }
    }
}

impl Sensing {
    pub(super) fn new(plan: SensingPlan, drives: u16) -> Result<(Self, Layout), PlanError> {
        let layout = plan.layout;
        let whole = plan.compression.scope == Scope::Skin;
        let sensing = Self {
            scan: Scan::new(&layout),
            pipeline: Pipeline {
                sense: Sense::new(&layout, plan.baseline, plan.health)?,
                compressor: Compressor::new(&layout, plan.compression)?,
                texture: None,
                drives,
                frames: 0,
                newest: None,
            },
            whole,
            last_received: None,
            next_round: Instant::ZERO,
        };
        Ok((sensing, layout))
    }

    /// Adds a texture.
    pub(super) fn sample(&mut self, sampler: Sampler) {
        self.pipeline.texture = Some(sampler);
    }

    /// The texture that is felt at `now`.
    pub(super) fn texture(&self, now: Instant) -> Option<Control> {
        self.pipeline.texture.as_ref()?.control(now)
    }

    /// Takes the hardness, 0 to 1, of a surface that was met or left since the last call, where that is known.
    pub(super) fn take_tap(&mut self) -> Option<f64> {
        self.pipeline.texture.as_mut()?.take_tap()
    }

    pub(super) fn allow(&mut self, clusters: usize) {
        self.pipeline.compressor.allow(clusters);
    }

    pub(super) const fn compressor(&self) -> &Compressor {
        &self.pipeline.compressor
    }

    pub(super) const fn baseline(&self) -> &Baseline {
        self.pipeline.sense.baseline()
    }

    pub(super) const fn monitor(&self) -> &Monitor {
        self.pipeline.sense.monitor()
    }

    /// The health of the skin up to `now`.
    pub(super) fn health(&mut self, now: Instant) -> HealthSummary {
        self.pipeline.sense.summary(now)
    }

    /// Returns true if anything is in contact.
    pub(super) fn is_touched(&self) -> bool {
        !self.pipeline.sense.relative().contacts().is_empty()
    }

    /// Takes the reference of every module anew.
    pub(super) fn rezero(&mut self) {
        self.pipeline.sense.rezero();
    }

    /// Time of the newest frame that was compressed.
    pub(super) const fn newest_frame(&self) -> Option<Instant> {
        self.pipeline.newest
    }

    pub(super) const fn last_received(&self) -> Option<Instant> {
        self.last_received
    }

    /// Takes one module's scan.
    pub(super) fn take(
        &mut self,
        scan: &ModuleScan<'_>,
        layout: &Layout,
        observer: &mut impl Observer,
    ) -> Result<(), ScanError> {
        self.scan.merge(layout, scan)?;
        let module = scan.module;
        if self.whole || module == self.pipeline.drives {
            self.last_received = self.last_received.max(Some(scan.at));
        }
        self.pipeline.frame(&self.scan, module, layout, observer);
        Ok(())
    }

    /// Takes contacts that another loop found, as of `at`. Taxels
    /// are not looked at any more: this loop has none of them.
    pub(super) fn hold(&mut self, at: Instant, contacts: &[Contact], observer: &mut impl Observer) {
        self.next_round = Instant::FAR_FUTURE;
        self.last_received = self.last_received.max(Some(at));
        let pipeline = &mut self.pipeline;
        pipeline.compressor.hold(contacts);
        pipeline.newest = Some(at);
        let number = pipeline.frames;
        pipeline.frames = pipeline.frames.saturating_add(1);
        observer.frame(&FrameReport {
            at,
            number,
            relative: pipeline.sense.relative(),
            contacts: pipeline.compressor.contacts(),
        });
    }

    /// Looks for taxels that send nothing.
    pub(super) fn look_round(
        &mut self,
        now: Instant,
        layout: &Layout,
        observer: &mut impl Observer,
    ) {
        if now >= self.next_round {
            self.next_round = now + ROUND;
            let report = &mut |i, condition| observer.taxel(now, i, condition);
            self.pipeline.sense.look_round(now, layout, report);
        }
    }
}
