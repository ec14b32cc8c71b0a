//! Taxel health: which taxels still tell something.
//!
//! Boards repeat stale rows silently, so what counts is how often a taxel's value changes, not how often a frame
//! arrives. This only reports; the loop decides what to leave out.

use alloc::vec::Vec;

use super::layout::Layout;
use super::scan::Scan;
use crate::units::{Duration, Instant};
use crate::vector::Vectors;

/// Limits of the monitor.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct HealthSettings {
    /// Received, but unchanged for longer than this: frozen.
    pub frozen_after: Duration,
    /// Not received for longer than this, or never within this time: dead.
    pub dead_after: Duration,
    /// A change of an axis from one reading to the next beyond this is a jump, counts.
    pub jump_counts: u16,
}

impl Default for HealthSettings {
    /// One second for both times, 20,000 counts.
    fn default() -> Self {
        Self {
            frozen_after: Duration::from_millis(1000),
            dead_after: Duration::from_millis(1000),
            jump_counts: 20_000,
        }
    }
}

/// What is wrong with a taxel, the worst first.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Condition {
    /// Not part of the run.
    Inactive,
    /// Never received, or not for long.
    Dead,
    /// Received, but its value stands still.
    Frozen,
    /// An axis is at the end of its range, and that is not where its skin rests.
    Saturated,
    /// Three jumps without 16 quiet readings after each.
    Jumping,
    /// Nothing.
    Good,
}

/// From three jumps in short order on.
const JUMPING: u16 = 40;

#[derive(Clone, Copy, Debug, Default)]
struct Taxel {
    received: u32,
    changed: u32,
    first_at: Instant,
    last_at: Instant,
    changed_at: Instant,
    /// 16 a jump, one less a quiet reading.
    jumps: u16,
    /// Whether the newest reading was a jump.
    jumped: bool,
}

/// Counts of conditions and the refresh rate over the active taxels.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct HealthSummary {
    /// Median over taxels of value changes per second.
    pub refresh_median_hz: f32,
    /// The slowest taxel's.
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
    active: Vec<bool>,
    single_axis: Vec<bool>,
    /// Whether it is known where a taxel's skin rests.
    learned: Vec<bool>,
    /// The end of the range that a single-axis taxel's skin rests at, if it rests at one.
    rests_at: Vec<Option<u16>>,
    /// The newest reading of every taxel; 0 before the first.
    counts: Vec<[u16; 3]>,
    taxels: Vec<Taxel>,
    vectors: Vectors,
    started: Option<Instant>,
    frames: u64,
    repeated: u64,
    rates: Vec<f32>,
}

impl Monitor {
    /// A monitor that has seen nothing.
    pub fn new(layout: &Layout, settings: HealthSettings) -> Self {
        let modules = || layout.modules().iter();
        Self {
            settings,
            active: modules().flat_map(|m| m.active()).copied().collect(),
            single_axis: modules()
                .flat_map(|m| m.points().iter().map(move |_| m.axes() == 1))
                .collect(),
            learned: alloc::vec![false; layout.taxels()],
            rests_at: alloc::vec![None; layout.taxels()],
            counts: alloc::vec![[0; 3]; layout.taxels()],
            taxels: alloc::vec![Taxel::default(); layout.taxels()],
            vectors: Vectors::widest(),
            started: None,
            frames: 0,
            repeated: 0,
            rates: Vec::with_capacity(layout.taxels()),
        }
    }

    /// Takes a frame of the whole skin. Returns whether any taxel changed; a scan of another layout is ignored.
    pub fn observe(&mut self, scan: &Scan) -> bool {
        if scan.counts().len() != self.taxels.len() {
            return false;
        }
        let repeated = self.repeated;
        self.observe_range(scan, 0..self.taxels.len());
        self.repeated == repeated
    }

    /// Takes one module's scan, `range` being [`Layout::range`]. Where it returns true, every active taxel of the
    /// module is in it, is [`Condition::Good`] at the time of the scan, and has not jumped; false says nothing.
    pub fn observe_range(&mut self, scan: &Scan, range: core::ops::Range<usize>) -> bool {
        let at = scan.at();
        self.started.get_or_insert(at);
        let end = range.end.min(self.taxels.len()).min(scan.counts().len());
        let range = range.start.min(end)..end;
        self.learn(scan, range.clone());
        let (jump, frozen_after) = (self.settings.jump_counts, self.settings.frozen_after);
        let (old, new) = (
            &mut self.counts[range.clone()],
            &scan.counts()[range.clone()],
        );
        let (before, now) = (old.as_flattened(), new.as_flattened());
        // One look at all of it, without a branch: mostly no value jumps and none is at an end of its range.
        let steady = self.vectors.run(
            #[inline(always)]
            || {
                let values = before.iter().zip(now);
                values.fold(true, |all, (a, b)| {
                    all & (a.abs_diff(*b) <= jump) & (b.wrapping_add(1) > 1)
                })
            },
        );
        let (mut well, mut any) = (steady, false);
        let listening = self.active[range.clone()].iter();
        let listening = listening.zip(&scan.fresh()[range.clone()]);
        let taxels = self.taxels[range].iter_mut().zip(old).zip(new);
        for (((t, old), new), (active, fresh)) in taxels.zip(listening) {
            if !(*active && *fresh) {
                well &= !active;
                continue;
            }
            if t.received == 0 {
                (t.first_at, t.changed_at) = (at, at);
                any = true;
            } else if new != old {
                t.changed = t.changed.saturating_add(1);
                t.changed_at = at;
                any = true;
                t.jumped = !steady && new.iter().zip(*old).any(|(a, b)| a.abs_diff(b) > jump);
                t.jumps = if t.jumped {
                    t.jumps.saturating_add(16).min(64)
                } else {
                    t.jumps.saturating_sub(1)
                };
            } else {
                t.jumped = false;
            }
            *old = *new;
            t.last_at = at;
            t.received = t.received.saturating_add(1);
            well &= (t.jumps < JUMPING) & (at.since(t.changed_at) <= frozen_after);
        }
        self.frames += 1;
        self.repeated += u64::from(!any);
        well
    }

    /// Finds out from the first scan of most of a module whether it rests at an end of its range: compensated readings
    /// of 8-bit skins are 0 without a touch. Only skins of one axis do; three zeros are a broken board's.
    fn learn(&mut self, scan: &Scan, range: core::ops::Range<usize>) {
        let known = self.learned.get(range.start).is_none_or(|known| *known);
        if known || range.is_empty() {
            return;
        }
        let active = self.active[range.clone()].iter().filter(|a| **a).count();
        let heard = |i: &usize| self.active[*i] && self.single_axis[*i] && scan.fresh()[*i];
        let heard_of = range.clone().filter(heard).count();
        if 2 * heard_of < active {
            return;
        }
        let most = |end: &u16| {
            let there = range.clone().filter(heard);
            let there = there.filter(|i| scan.counts()[*i][2] == *end);
            2 * there.count() > heard_of
        };
        let end = [0, u16::MAX].into_iter().find(most);
        self.learned[range.clone()].fill(true);
        self.rests_at[range].fill(end);
    }

    /// What is wrong with a taxel at `now`; the worst of several.
    pub fn condition(&self, index: usize, now: Instant) -> Condition {
        let Some(t) = self.taxels.get(index).filter(|_| self.active[index]) else {
            return Condition::Inactive;
        };
        let silent = if t.received == 0 {
            now.since(self.started.unwrap_or(now))
        } else {
            now.since(t.last_at)
        };
        let used = if self.single_axis[index] { 2.. } else { 0.. };
        if silent > self.settings.dead_after {
            Condition::Dead
        } else if t.received > 0 && t.last_at.since(t.changed_at) > self.settings.frozen_after {
            Condition::Frozen
        } else if t.received > 0
            && self.counts[index][used]
                .iter()
                .any(|c| (*c == 0 || *c == u16::MAX) && self.rests_at[index] != Some(*c))
        {
            Condition::Saturated
        } else if t.jumps >= JUMPING {
            Condition::Jumping
        } else {
            Condition::Good
        }
    }

    /// Whether a taxel's newest reading jumped: one such reading is no touch.
    pub fn has_jumped(&self, index: usize) -> bool {
        self.taxels.get(index).is_some_and(|t| t.jumped)
    }

    /// Readings of a taxel so far, and when the last one came; `None` if none did.
    pub fn received(&self, index: usize) -> Option<(u32, Instant)> {
        let t = self.taxels.get(index).filter(|t| t.received > 0)?;
        Some((t.received, t.last_at))
    }

    /// Value changes and readings of a taxel per second, since its first reading; 0 before the second one.
    pub fn rates_hz(&self, index: usize) -> (f32, f32) {
        let Some(t) = self.taxels.get(index) else {
            return (0.0, 0.0);
        };
        let span = t.last_at.since(t.first_at).as_secs_f64();
        if span <= 0.0 {
            return (0.0, 0.0);
        }
        let rate = |n: u32| (f64::from(n) / span) as f32;
        (rate(t.changed), rate(t.received.saturating_sub(1)))
    }

    /// The summary at `now`; allocates nothing.
    pub fn summary(&mut self, now: Instant) -> HealthSummary {
        let mut s = HealthSummary {
            frames: self.frames,
            repeated: self.repeated,
            ..HealthSummary::default()
        };
        for i in 0..self.taxels.len() {
            match self.condition(i, now) {
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
        let active = (0..self.taxels.len()).filter(|i| self.active[*i]);
        rates.extend(active.map(|i| pick(self.rates_hz(i))));
        rates.sort_unstable_by(f32::total_cmp);
        let n = rates.len();
        let median = match (rates.get(n.saturating_sub(1) / 2), rates.get(n / 2)) {
            (Some(a), Some(b)) => 0.5 * (a + b),
            _ => 0.0,
        };
        self.rates = rates;
        median
    }
}

#[cfg(test)]
#[path = "health_tests.rs"]
mod tests;
