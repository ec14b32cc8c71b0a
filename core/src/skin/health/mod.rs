//! Taxel health: the taxels that still carry information.
//!
//! Boards repeat stale rows silently, so the changes of a taxel's value count, not the frames that arrive. The
//! monitor only reports; the loop decides on the taxels to leave out.

mod taxels;

use alloc::vec::Vec;

use super::layout::Layout;
use super::scan::Scan;
use crate::listed::listed;
use crate::statistics::quantile;
use crate::units::{Duration, Instant};

use taxels::Taxels;

/// Limits of the monitor.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct HealthSettings {
    /// Age of an unchanged value beyond which a taxel that is received is frozen.
    pub frozen_after: Duration,
    /// Age of the newest reading beyond which a taxel is dead; a taxel never received for this long is dead too.
    pub dead_after: Duration,
    /// Change of an axis from one reading to the next beyond which it is a jump, counts.
    pub jump_counts: u16,
}

impl Default for HealthSettings {
    /// Limits of one second for both times, and of 20,000 counts.
    fn default() -> Self {
        Self {
            frozen_after: Duration::from_millis(1000),
            dead_after: Duration::from_millis(1000),
            jump_counts: 20_000,
        }
    }
}

listed! {
    /// Conditions of a taxel, the worst first.
    #[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
    pub enum Condition: word {
        /// A taxel that is no part of the run.
        Inactive = "inactive",
        /// A taxel that was never received, or not for long.
        Dead = "dead",
        /// A taxel that is received, but whose value stands still.
        Frozen = "frozen",
        /// A taxel with an axis at an end of its range where its skin does not rest.
        Saturated = "saturated",
        /// A taxel with three jumps without 16 quiet readings after each.
        Jumping = "jumping",
        /// A taxel without a defect.
        Good = "good",
    }
}

/// Least tally of a taxel that jumps: three jumps in short order.
const JUMPING: u16 = 40;

/// Counts of conditions and the refresh rate over the active taxels.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct HealthSummary {
    /// Median over taxels of value changes per second.
    pub refresh_median_hz: f32,
    /// Value changes per second of the slowest taxel.
    pub refresh_min_hz: f32,
    /// Median over taxels of readings per second.
    pub received_median_hz: f32,
    /// Frozen taxels.
    pub frozen: u32,
    /// Dead taxels.
    pub dead: u32,
    /// Saturated taxels.
    pub saturated: u32,
    /// Jumping taxels.
    pub jumping: u32,
    /// Frames seen.
    pub frames: u64,
    /// Frames in which no taxel changed.
    pub repeated: u64,
}

/// Watches every taxel of a skin.
#[derive(Clone, Debug)]
pub struct Monitor {
    settings: HealthSettings,
    taxels: Taxels,
    started: Option<Instant>,
    frames: u64,
    repeated: u64,
    rates: Vec<f32>,
}

impl Monitor {
    /// A monitor that has seen nothing.
    pub fn new(layout: &Layout, settings: HealthSettings) -> Self {
        Self {
            settings,
            taxels: Taxels::new(layout, settings),
            started: None,
            frames: 0,
            repeated: 0,
            rates: Vec::with_capacity(layout.taxels()),
        }
    }

    /// Takes a frame of the whole skin. Returns true if any taxel changed; a scan of another layout is ignored.
    pub fn observe(&mut self, scan: &Scan) -> bool {
        if scan.counts().len() != self.taxels.active.len() {
            return false;
        }
        self.started.get_or_insert(scan.at());
        let modules = 0..self.taxels.modules();
        let any = modules.fold(false, |any, m| any | self.taxels.observe(scan, m).any);
        self.frames += 1;
        self.repeated += u64::from(!any);
        any
    }

    /// Takes one module's scan. Where it returns true, every active taxel of the module is in it, is
    /// [`Condition::Good`] at the time of the scan, and has not jumped; false says nothing. A scan of another layout is
    /// ignored.
    pub fn observe_module(&mut self, scan: &Scan, module: usize) -> bool {
        if scan.counts().len() != self.taxels.active.len() || module >= self.taxels.modules() {
            return false;
        }
        self.started.get_or_insert(scan.at());
        let seen = self.taxels.observe(scan, module);
        self.frames += 1;
        self.repeated += u64::from(!seen.any);
        seen.well
    }

    /// Returns true if [`Self::observe_module`] was true of a module's newest scan and still is at `now`. The caller
    /// then needs to look at no taxel by itself.
    pub fn is_well(&self, module: usize, now: Instant) -> bool {
        let lasts = |at| now.since(at) <= self.settings.dead_after;
        self.taxels.well_at(module).is_some_and(lasts)
    }

    /// The condition of a taxel at `now`; the worst of several.
    pub fn condition(&self, index: usize, now: Instant) -> Condition {
        let t = &self.taxels;
        if !t.active.get(index).is_some_and(|active| *active) {
            return Condition::Inactive;
        }
        let Some((_, last_at)) = t.received(index) else {
            let silent = now.since(self.started.unwrap_or(now));
            return match silent > self.settings.dead_after {
                true => Condition::Dead,
                false => Condition::Good,
            };
        };
        if now.since(last_at) > self.settings.dead_after {
            Condition::Dead
        } else if last_at.since(t.changed_at(index)) > self.settings.frozen_after {
            Condition::Frozen
        } else if t.is_at_an_end(index) {
            Condition::Saturated
        } else if t.is_jumping(index) {
            Condition::Jumping
        } else {
            Condition::Good
        }
    }

    /// Returns true if a taxel's newest reading jumped: one such reading is no touch.
    pub fn has_jumped(&self, index: usize) -> bool {
        self.taxels.has_jumped(index)
    }

    /// Readings of a taxel so far, and the time of the last one; `None` if none came.
    pub fn received(&self, index: usize) -> Option<(u32, Instant)> {
        self.taxels.received(index)
    }

    /// Value changes and readings of a taxel per second, since its first reading; 0 before the second one.
    pub fn rates_hz(&self, index: usize) -> (f32, f32) {
        let Some((received, last_at)) = self.taxels.received(index) else {
            return (0.0, 0.0);
        };
        let (changed, first_at) = self.taxels.changes(index);
        let span = last_at.since(first_at).as_secs_f64();
        if span <= 0.0 {
            return (0.0, 0.0);
        }
        let rate = |n: u32| (f64::from(n) / span) as f32;
        (rate(changed), rate(received.saturating_sub(1)))
    }

    /// The summary at `now`. Every taxel counts by its condition or a worse one of `worst`, which has all taxels or
    /// none. Allocates nothing.
    pub fn summary(&mut self, worst: &[Condition], now: Instant) -> HealthSummary {
        let mut s = HealthSummary {
            frames: self.frames,
            repeated: self.repeated,
            ..HealthSummary::default()
        };
        for i in 0..self.taxels.active.len() {
            let condition = self.condition(i, now);
            match worst
                .get(i)
                .map_or(condition, |worst| condition.min(*worst))
            {
                Condition::Dead => s.dead += 1,
                Condition::Frozen => s.frozen += 1,
                Condition::Saturated => s.saturated += 1,
                Condition::Jumping => s.jumping += 1,
                Condition::Inactive | Condition::Good => {}
            }
        }
        s.received_median_hz = self.sorted_rates(|r| r.1);
        s.refresh_median_hz = self.sorted_rates(|r| r.0);
        s.refresh_min_hz = self.rates.first().copied().unwrap_or(0.0);
        s
    }

    /// Sorts the active taxels' rates and returns their median.
    fn sorted_rates(&mut self, pick: fn((f32, f32)) -> f32) -> f32 {
        let mut rates = core::mem::take(&mut self.rates);
        rates.clear();
        let active = (0..self.taxels.active.len()).filter(|i| self.taxels.active[*i]);
        rates.extend(active.map(|i| pick(self.rates_hz(i))));
        rates.sort_unstable_by(f32::total_cmp);
        let median = quantile(&rates, 0.5).map_or(0.0, |middle| middle.between() as f32);
        self.rates = rates;
        median
    }
}

#[cfg(test)]
mod tests;
