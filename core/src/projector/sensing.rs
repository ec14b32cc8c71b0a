//! The sensor's half of the loop: frames off the bus become scans, scans become contacts.
//!
//! A frame is a scan of the driving module; the other modules contribute their newest readings.

use alloc::boxed::Box;
use alloc::vec::Vec;
use core::ops::Range;

use crate::bus::Received;
use crate::contact::{Compressor, Scope};
use crate::skin::{
    self, Condition, FrameError, Initialiser, Layout, Monitor, Phase, RelativeFrame, Scan,
    ScanAssembler,
};
use crate::texture::Control;
use crate::units::{Duration, Instant};
use crate::wire::uskin::{Raw, Reading};

use super::routes::Routes;
use super::texture::Sampler;
use super::{FrameReport, Observer, PlanError, SensingPlan};

/// How often taxels are looked at of which nothing comes.
const ROUND: Duration = Duration::from_millis(100);

/// Everything behind the assembler, so that a finished scan can be handed on while it is borrowed.
#[derive(Debug)]
struct Pipeline {
    initialiser: Initialiser,
    relative: RelativeFrame,
    compressor: Compressor,
    monitor: Monitor,
    texture: Option<Sampler>,
    /// Whether `relative` leaves out what the initialiser found faulty.
    masked: bool,
    /// Each taxel's condition as it was last reported.
    conditions: Box<[Condition]>,
    drives: u16,
    frames: u32,
    /// Time of the newest frame that was compressed.
    newest: Option<Instant>,
    /// Frames that could not be compressed; the layout makes that impossible, so it is counted, not hidden.
    refused: Option<FrameError>,
}

/// The state of the sensor half.
#[derive(Debug)]
pub(super) struct Sensing {
    routes: Routes,
    assembler: ScanAssembler,
    pipeline: Pipeline,
    /// Whether every module drives the display, or one.
    whole: bool,
    /// When something came that drives the display.
    last_received: Option<Instant>,
    /// When to look for taxels of which nothing comes.
    next_round: Instant,
    foreign: u64,
}

impl Pipeline {
    fn frame(&mut self, scan: &Scan, module: u16, layout: &Layout, observer: &mut impl Observer) {
        self.watch_for_new_board(usize::from(module), layout);
        let range = layout.range(usize::from(module));
        let well = self.monitor.observe_range(scan, range.clone());
        if !(well && self.is_used_whole(range)) {
            self.examine(scan.at(), usize::from(module), layout, observer);
        }
        if let Some(texture) = &mut self.texture {
            // As the last frame has it: a scan's own touch is known one frame later.
            let touched = !self.relative.contacts_of(usize::from(module)).is_empty();
            texture.scan(scan, module, touched, observer);
        }
        if module != self.drives {
            return;
        }
        let number = self.frames;
        self.frames = self.frames.saturating_add(1);
        if self.initialiser.phase() != Phase::Ready && self.initialiser.feed(scan) != Phase::Ready {
            return;
        }
        if !self.masked {
            self.initialiser.mask(&mut self.relative);
            self.masked = true;
        }
        let advanced = self.initialiser.advance(scan, &mut self.relative);
        let compressed = advanced.and_then(|news| {
            if news || !self.compressor.repeat() {
                self.compressor.compress(&self.relative)?;
            }
            Ok(())
        });
        match compressed {
            Ok(()) => {
                self.newest = Some(scan.at());
                observer.frame(&FrameReport {
                    at: scan.at(),
                    number,
                    relative: &self.relative,
                    contacts: self.compressor.contacts(),
                });
            }
            Err(error) => self.refused = Some(error),
        }
    }
}

impl Pipeline {
    /// A module all of whose taxels were dead, and of which a scan now comes, may have another board: where the
    /// reference follows drift, the module starts over.
    fn watch_for_new_board(&mut self, module: usize, layout: &Layout) {
        let conditions = &self.conditions[layout.range(module)];
        let silent = |c: &Condition| matches!(c, Condition::Dead | Condition::Inactive);
        if self.initialiser.follows_drift()
            && conditions.iter().all(silent)
            && conditions.contains(&Condition::Dead)
        {
            self.initialiser.restart(module);
        }
    }

    /// Whether nothing is left to do for taxels that are well: they were, and are left out only where the
    /// initialiser says so.
    fn is_used_whole(&self, range: Range<usize>) -> bool {
        let conditions = self.conditions[range.clone()].iter();
        let well = |c: &Condition| (*c == Condition::Good) | (*c == Condition::Inactive);
        let (used, usable) = (self.relative.usable(), self.initialiser.usable());
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
            self.relative
                .set_usable(i, sound && self.initialiser.usable()[i]);
        }
    }
}

impl Sensing {
    pub(super) fn new(plan: SensingPlan, drives: u16) -> Result<(Self, Layout), PlanError> {
        let layout = plan.layout;
        let whole = plan.compression.scope == Scope::Skin;
        let mut assembler = ScanAssembler::new(&layout, plan.gap);
        let mut senders = Vec::new();
        for (index, module) in layout.modules().iter().enumerate() {
            let wiring = module.wiring();
            let active = (0..module.points().len()).filter(|&i| module.active()[i]);
            let order = |i| wiring.and_then(|w| w.order(w.place(0, i)?));
            if let Some(last) = active.filter_map(order).max() {
                assembler.set_last_order(index, last as u32); // a board has at most 64 taxels
            }
            if let Some((address, wiring)) = module.address().zip(wiring) {
                senders.push((index as u16, address, wiring)); // at most 4096 modules
            }
        }
        let initialiser = Initialiser::new(&layout, plan.initialiser)?;
        let sensing = Self {
            routes: Routes::new(plan.profile, &senders),
            assembler,
            pipeline: Pipeline {
                relative: RelativeFrame::new(&layout),
                compressor: Compressor::new(&layout, plan.compression)?,
                monitor: Monitor::new(&layout, plan.health),
                texture: None,
                initialiser,
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
                drives,
                frames: 0,
                newest: None,
                refused: None,
            },
            whole,
            last_received: None,
            next_round: Instant::ZERO,
            foreign: 0,
        };
        Ok((sensing, layout))
    }

    /// With a texture.
    pub(super) fn sample(&mut self, sampler: Sampler) {
        self.pipeline.texture = Some(sampler);
    }

    /// The texture that is felt at `now`.
    pub(super) fn texture(&self, now: Instant) -> Option<Control> {
        self.pipeline.texture.as_ref()?.control(now)
    }

    pub(super) const fn compressor(&self) -> &Compressor {
        &self.pipeline.compressor
    }

    pub(super) const fn initialiser(&self) -> &Initialiser {
        &self.pipeline.initialiser
    }

    pub(super) const fn monitor(&self) -> &Monitor {
        &self.pipeline.monitor
    }

    pub(super) const fn monitor_mut(&mut self) -> &mut Monitor {
        &mut self.pipeline.monitor
    }

    pub(super) const fn refused(&self) -> Option<&FrameError> {
        self.pipeline.refused.as_ref()
    }

    /// Time of the newest frame that was compressed.
    pub(super) const fn newest_frame(&self) -> Option<Instant> {
        self.pipeline.newest
    }

    pub(super) const fn last_received(&self) -> Option<Instant> {
        self.last_received
    }

    pub(super) const fn foreign(&self) -> u64 {
        self.foreign
    }

    pub(super) fn lost(&self) -> u64 {
        self.assembler.lost()
    }

    pub(super) fn lost_of(&self, module: usize) -> u64 {
        self.assembler.lost_of(module)
    }

    /// Takes one frame off a bus. What is no sensor data of this layout is counted and left.
    pub(super) fn take(
        &mut self,
        received: &Received,
        layout: &Layout,
        observer: &mut impl Observer,
    ) {
        if self.reading(received, layout, observer).is_none() {
            self.foreign = self.foreign.saturating_add(1);
        }
    }

    fn reading(
        &mut self,
        received: &Received,
        layout: &Layout,
        observer: &mut impl Observer,
    ) -> Option<()> {
        // Commands are shorter than data; nothing else tells them apart.
        let Reading { x, y, z } = Raw::new(received.frame.data())?.reading();
        let route = self.routes.find(received.bus, received.frame.id())?;
        let reading = skin::Reading {
            module: route.module,
            taxel: u32::from(route.taxel),
            order: u32::from(route.order),
            counts: [x, y, z],
            at: received.at,
        };
        let pipeline = &mut self.pipeline;
        let push = self.assembler.push(&reading, |scan, m| {
            pipeline.frame(scan, m, layout, observer)
        });
        push.ok()?;
        if self.whole || route.module == self.pipeline.drives {
            self.last_received = Some(received.at);
        }
        Some(())
    }

    /// Ends scans whose remaining readings did not come in time.
    pub(super) fn flush(&mut self, now: Instant, layout: &Layout, observer: &mut impl Observer) {
        let pipeline = &mut self.pipeline;
        self.assembler
            .flush(now, |scan, m| pipeline.frame(scan, m, layout, observer));
        if now >= self.next_round {
            self.next_round = now + ROUND;
            for module in 0..layout.modules().len() {
                pipeline.examine(now, module, layout, observer);
            }
        }
    }
}
