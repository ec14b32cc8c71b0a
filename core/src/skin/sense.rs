//! Scans in, relative frames out: the baseline and the monitor of a skin together, and which taxels are left out.
//!
//! Runs, `hil contacts`, links and Python all take their frames here.

use alloc::boxed::Box;
use core::ops::Range;

use super::baseline::{Baseline, BaselineError, BaselinePhase, BaselineSettings};
use super::health::{Condition, HealthSettings, HealthSummary, Monitor};
use super::layout::Layout;
use super::relative::{FrameError, RelativeFrame};
use super::scan::Scan;
use crate::units::{Duration, Instant};

/// What takes a taxel whose health changed.
type Report<'a> = dyn FnMut(usize, Condition) + 'a;

/// The way from scans to relative frames.
#[derive(Debug)]
pub struct Sense {
    baseline: Baseline,
    relative: RelativeFrame,
    monitor: Monitor,
    /// Whether `relative` leaves out what the baseline found faulty.
    masked: bool,
    /// Each taxel's condition as it was last reported, and the worst it ever was.
    conditions: Box<[Condition]>,
    worst: Box<[Condition]>,
    /// Modules of which [`Self::is_used_whole`] holds as long as nothing that it looks at changes.
    used_whole: Box<[bool]>,
    /// When each module was last heard.
    heard: Box<[Option<Instant>]>,
    silence: Duration,
}

impl Sense {
    /// For a skin of which nothing is known yet.
    ///
    /// # Errors
    /// Settings of the baseline that cannot be.
    pub fn new(
        layout: &Layout,
        baseline: BaselineSettings,
        health: HealthSettings,
    ) -> Result<Self, BaselineError> {
        let baseline = Baseline::new(layout, baseline)?;
        let modules = layout.modules().len();
        let active = layout.modules().iter().flat_map(|m| m.active());
        let condition = |active: &bool| match active {
            true => Condition::Good,
            false => Condition::Inactive,
        };
        let conditions: Box<[Condition]> = active.map(condition).collect();
        Ok(Self {
            relative: RelativeFrame::new(layout),
            monitor: Monitor::new(layout, health),
            baseline,
            masked: false,
            worst: conditions.clone(),
            conditions,
            used_whole: alloc::vec![false; modules].into(),
            heard: alloc::vec![None; modules].into(),
            silence: health.dead_after,
        })
    }

    /// Looks at a module's newest scan: `report` takes the taxels whose health changed, and ill ones are left out from
    /// this scan on. A module that was silent may have another board.
    pub fn watch(&mut self, scan: &Scan, module: usize, layout: &Layout, report: &mut Report<'_>) {
        if let Some(heard) = self.heard.get_mut(module) {
            let before = heard.replace(scan.at());
            if before.is_some_and(|at| scan.at().since(at) > self.silence) {
                self.baseline.doubt(module);
            }
        }
        let well = self.monitor.observe_module(scan, module);
        if !(well && self.is_used_whole(module, layout)) {
            self.examine(scan.at(), module, layout, report);
        }
    }

    /// Takes a frame of the whole skin. Returns whether its relative frame may be other than before; `None` while the
    /// reference is made.
    ///
    /// # Errors
    /// A scan of another layout.
    pub fn frame(&mut self, scan: &Scan) -> Result<Option<bool>, FrameError> {
        let ready = BaselinePhase::Ready;
        if self.baseline.phase() != ready && self.baseline.feed(scan) != ready {
            return Ok(None);
        }
        if !self.masked {
            self.baseline.mask(&mut self.relative);
            self.masked = true;
            self.used_whole.fill(false);
        }
        self.baseline.advance(scan, &mut self.relative).map(Some)
    }

    /// Looks for taxels of which nothing comes.
    pub fn look_round(&mut self, now: Instant, layout: &Layout, report: &mut Report<'_>) {
        for module in 0..self.used_whole.len() {
            let well = self.monitor.is_well(module, now);
            if !(well && self.is_used_whole(module, layout)) {
                self.examine(now, module, layout, report);
            }
        }
    }

    /// Takes the reference of every module anew, from the next frame on.
    pub fn rezero(&mut self) {
        self.baseline.rezero();
        self.used_whole.fill(false);
    }

    /// Whether nothing is left to do for taxels that are well: they were, and are left out only where the
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
    fn examine(&mut self, now: Instant, module: usize, layout: &Layout, report: &mut Report<'_>) {
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
                report(i, condition);
            }
        }
        for i in range.clone() {
            if self.conditions[i] != Condition::Frozen || !still {
                self.worst[i] = self.worst[i].min(self.conditions[i]);
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

    /// The newest relative frame.
    pub const fn relative(&self) -> &RelativeFrame {
        &self.relative
    }

    /// Reference, threshold and faulty taxels.
    pub const fn baseline(&self) -> &Baseline {
        &self.baseline
    }

    /// Every taxel's rate and condition.
    pub const fn monitor(&self) -> &Monitor {
        &self.monitor
    }

    /// The health of the skin up to `now`: every taxel counts once, by the worst that was found of it.
    pub fn summary(&mut self, now: Instant) -> HealthSummary {
        self.monitor.summary(&self.worst, now)
    }
}
