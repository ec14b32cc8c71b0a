//! The sensor's half of the loop: scans of modules become frames of the skin, frames become contacts.
//!
//! A frame is a scan of the driving module; the other modules contribute their newest readings.

use alloc::boxed::Box;
use core::ops::Range;

use crate::contact::{Compressor, Contact, Scope};
use crate::skin::{
    Baseline, BaselinePhase, Condition, Layout, ModuleScan, Monitor, RelativeFrame, Scan, ScanError,
};
use crate::texture::Control;
use crate::units::{Duration, Instant};

use super::texture::Sampler;
use super::{FrameReport, Observer, PlanError, SensingPlan};

/// Time between looks for taxels that send nothing.
const ROUND: Duration = Duration::from_millis(100);

/// Everything behind the scan, so that it can be handed on while it is borrowed.
#[derive(Debug)]
struct Pipeline {
    baseline: Baseline,
    relative: RelativeFrame,
    compressor: Compressor,
    monitor: Monitor,
    texture: Option<Sampler>,
    /// `true` where `relative` leaves out what the baseline found faulty.
    masked: bool,
    /// Each taxel's condition as it was last reported.
    conditions: Box<[Condition]>,
    /// Modules of which [`Self::is_used_whole`] holds as long as nothing that it looks at changes.
    used_whole: Box<[bool]>,
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
        self.watch_for_new_board(usize::from(module), layout);
        let well = self.monitor.observe_module(scan, usize::from(module));
        if !(well && self.is_used_whole(usize::from(module), layout)) {
            self.examine(scan.at(), usize::from(module), layout, observer);
        }
        if let Some(texture) = &mut self.texture {
            // As the last frame has it: a scan's own touch is known one frame later.
            let touched = !self.relative.contacts_of(usize::from(module)).is_empty();
            texture.scan(scan, (module, touched), &self.baseline, observer);
        }
        if module != self.drives {
            return;
        }
        let number = self.frames;
        self.frames = self.frames.saturating_add(1);
        if self.baseline.phase() != BaselinePhase::Ready
            && self.baseline.feed(scan) != BaselinePhase::Ready
        {
            return;
        }
        if !self.masked {
            self.baseline.mask(&mut self.relative);
            self.masked = true;
            self.used_whole.fill(false);
        }
        let advanced = self.baseline.advance(scan, &mut self.relative);
        let compressed = advanced.and_then(|news| {
            if news || !self.compressor.repeat() {
                self.compressor.compress(&self.relative)?;
            }
            Ok(())
        });
        // Only a frame of another layout is refused, and all of these are the loop's own.
        if compressed.is_ok() {
            self.newest = Some(scan.at());
            observer.frame(&FrameReport {
                at: scan.at(),
                number,
                relative: &self.relative,
                contacts: self.compressor.contacts(),
            });
        }
    }
}

impl Pipeline {
    /// A module all of whose taxels were dead, and of which a scan now comes, may have another board: where the
    /// reference follows drift, the module starts over.
    fn watch_for_new_board(&mut self, module: usize, layout: &Layout) {
        let conditions = &self.conditions[layout.range(module)];
        let silent = |c: &Condition| matches!(c, Condition::Dead | Condition::Inactive);
        if self.baseline.follows_drift()
            && conditions.iter().all(silent)
            && conditions.contains(&Condition::Dead)
        {
            self.baseline.restart(module);
            self.used_whole.fill(false);
        }
    }

    /// Tells whether nothing is left to do for well taxels: they were well before, and are left out only where the
    /// baseline says so.
    fn is_used_whole(&mut self, module: usize, layout: &Layout) -> bool {
        // A baseline that takes a module's reference anew changes by itself what may be used.
        let settled = !self.baseline.is_restarting();
        if settled && self.used_whole[module] {
            return true;
        }
        let is_used = self.looks_used_whole(layout.range(module));
        self.used_whole[module] = settled && is_used;
        is_used
    }

    fn looks_used_whole(&self, range: Range<usize>) -> bool {
        let conditions = self.conditions[range.clone()].iter();
        let well = |c: &Condition| (*c == Condition::Good) | (*c == Condition::Inactive);
        let (used, usable) = (self.relative.usable(), self.baseline.usable());
        conditions.fold(true, |all, c| all & well(c))
            && (!self.masked || used[range.clone()] == usable[range])
    }

    /// Looks at the taxels of a module: reports those whose health changed, and leaves the ill ones out.
    /// Where a whole module stands still it may be a skin without noise, so it is only reported.
    fn examine(
        &mut self,
        now: Instant,
        module: usize,
        layout: &Layout,
        observer: &mut impl Observer,
    ) {
        let range = layout.range(module);
        let mut still = true;
        for i in range.clone() {
            let condition = self.monitor.condition(i, now);
            still &= !matches!(
                condition,
                Condition::Good | Condition::Saturated | Condition::Jumping
            );
            if self.conditions[i] != condition {
                self.conditions[i] = condition;
                self.used_whole[module] = false;
                observer.taxel(now, i, condition);
            }
        }
        if !self.masked {
            return;
        }
        for i in range {
            let sound = match self.conditions[i] {
                Condition::Good => !self.monitor.has_jumped(i),
                Condition::Frozen => still,
                _ => false,
            };
            let usable = sound && self.baseline.usable()[i];
            if self.relative.usable()[i] != usable {
                self.relative.set_usable(i, usable);
                self.used_whole[module] = false;
            }
        }
    }
}

impl Sensing {
    pub(super) fn new(plan: SensingPlan, drives: u16) -> Result<(Self, Layout), PlanError> {
        let layout = plan.layout;
        let whole = plan.compression.scope == Scope::Skin;
        let baseline = Baseline::new(&layout, plan.baseline)?;
        let sensing = Self {
            scan: Scan::new(&layout),
            pipeline: Pipeline {
                relative: RelativeFrame::new(&layout),
                compressor: Compressor::new(&layout, plan.compression)?,
                monitor: Monitor::new(&layout, plan.health),
                texture: None,
                baseline,
                masked: false,
                conditions: layout
                    .modules()
                    .iter()
                    .flat_map(|m| m.active())
                    .map(|active| {
                        if *active {
                            Condition::Good
                        } else {
                            Condition::Inactive
                        }
                    })
                    .collect(),
                used_whole: alloc::vec![false; layout.modules().len()].into(),
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
        &self.pipeline.baseline
    }

    pub(super) const fn monitor(&self) -> &Monitor {
        &self.pipeline.monitor
    }

    pub(super) const fn monitor_mut(&mut self) -> &mut Monitor {
        &mut self.pipeline.monitor
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
            relative: &pipeline.relative,
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
            for module in 0..layout.modules().len() {
                let well = self.pipeline.monitor.is_well(module, now);
                if !(well && self.pipeline.is_used_whole(module, layout)) {
                    self.pipeline.examine(now, module, layout, observer);
                }
            }
        }
    }
}
