//! Taxel health: which taxels still tell something.
//!
//! Boards repeat stale rows silently, so what counts is how often a taxel's value changes, not how often a frame
//! arrives. This only reports; the loop decides what to leave out.

use alloc::vec::Vec;
use core::ops::Range;

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
    /// An axis is at the end of its range.
    Saturated,
    /// Three jumps without 16 quiet readings after each.
    Jumping,
    /// Nothing.
    Good,
}

/// From three jumps in short order on.
const JUMPING: u16 = 40;

/// What is known of every taxel: a list per quantity, so that many taxels are looked at in one go.
#[derive(Clone, Debug)]
struct Taxels {
    /// The newest readings; 0 before the first.
    counts: Vec<[u16; 3]>,
    received: Vec<u32>,
    changed: Vec<u32>,
    first_at: Vec<Instant>,
    last_at: Vec<Instant>,
    changed_at: Vec<Instant>,
    /// 16 a jump, one less a quiet reading.
    jumps: Vec<u16>,
    /// Whether the newest reading was a jump.
    jumped: Vec<bool>,
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
    taxels: Taxels,
    vectors: Vectors,
    started: Option<Instant>,
    frames: u64,
    repeated: u64,
    rates: Vec<f32>,
}

impl Taxels {
    fn new(n: usize) -> Self {
        let never = || alloc::vec![Instant::ZERO; n];
        Self {
            counts: alloc::vec![[0; 3]; n],
            received: alloc::vec![0; n],
            changed: alloc::vec![0; n],
            first_at: never(),
            last_at: never(),
            changed_at: never(),
            jumps: alloc::vec![0; n],
            jumped: alloc::vec![false; n],
        }
    }
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
            taxels: Taxels::new(layout.taxels()),
            vectors: Vectors::widest(),
            started: None,
            frames: 0,
            repeated: 0,
            rates: Vec::with_capacity(layout.taxels()),
        }
    }

    /// Takes a frame of the whole skin. Returns whether any taxel changed; a scan of another layout is ignored.
    pub fn observe(&mut self, scan: &Scan) -> bool {
        if scan.counts().len() != self.active.len() {
            return false;
        }
        let repeated = self.repeated;
        self.observe_range(scan, 0..self.active.len());
        self.repeated == repeated
    }

    /// Takes one module's scan, `range` being [`Layout::range`]. Where it returns true, every active taxel of the
    /// module is in it, is [`Condition::Good`] at the time of the scan, and has not jumped; false says nothing.
    pub fn observe_range(&mut self, scan: &Scan, range: Range<usize>) -> bool {
        self.started.get_or_insert(scan.at());
        let end = range.end.min(self.active.len()).min(scan.counts().len());
        let range = range.start.min(end)..end;
        let steady = self.is_steady(scan, range.clone());
        let (any, well) = if steady && self.listens_whole(scan, range.clone()) {
            self.observe_whole(scan, range)
        } else {
            self.observe_each(scan, range, steady)
        };
        self.frames += 1;
        self.repeated += u64::from(!any);
        well && steady
    }

    /// Whether no active taxel's value jumps and none is at an end of its range: one look at all of it, without a branch.
    fn is_steady(&self, scan: &Scan, range: Range<usize>) -> bool {
        let jump = self.settings.jump_counts;
        let taxels = self.taxels.counts[range.clone()].iter();
        let taxels = taxels.zip(&scan.counts()[range.clone()]);
        let kinds = self.active[range.clone()].iter();
        let taxels = taxels.zip(kinds.zip(&self.single_axis[range]));
        self.vectors.run(
            #[inline(always)]
            || {
                taxels.fold(true, |all, ((before, now), (active, single))| {
                    // An axis that a taxel does not have reads 0.
                    let least = [u16::from(!single), u16::from(!single), 1];
                    let axes = before.iter().zip(now).zip(least);
                    let steady = axes.fold(true, |all, ((a, b), least)| {
                        all & (a.abs_diff(*b) <= jump) & (*b >= least) & (*b < u16::MAX)
                    });
                    all & (steady | !active)
                })
            },
        )
    }

    /// Whether every active taxel is in the scan, and was received before.
    fn listens_whole(&self, scan: &Scan, range: Range<usize>) -> bool {
        let listening = self.active[range.clone()].iter();
        let listening = listening.zip(&scan.fresh()[range.clone()]);
        let listening = listening.zip(&self.taxels.received[range]);
        self.vectors.run(
            #[inline(always)]
            || {
                listening.fold(true, |all, ((active, fresh), received)| {
                    all & (!active | (*fresh & (*received > 0)))
                })
            },
        )
    }

    /// As [`Self::observe_each`] where all active taxels listen and are steady, without a branch.
    fn observe_whole(&mut self, scan: &Scan, range: Range<usize>) -> (bool, bool) {
        let (at, frozen_after) = (scan.at(), self.settings.frozen_after);
        let t = &mut self.taxels;
        let active = &self.active[range.clone()];
        let new = scan.counts()[range.clone()].iter().zip(active);
        let old = t.counts[range.clone()].iter_mut().zip(new);
        let changes = t.changed[range.clone()].iter_mut();
        let changes = changes.zip(&mut t.changed_at[range.clone()]);
        let changes = changes.zip(&mut t.jumps[range.clone()]);
        let seen = self.vectors.run(
            #[inline(always)]
            || {
                let mut seen = (false, true);
                for ((old, (new, active)), ((changed, changed_at), jumps)) in old.zip(changes) {
                    let news = (old[0] != new[0]) | (old[1] != new[1]) | (old[2] != new[2]);
                    let news = news & active;
                    *changed = changed.saturating_add(u32::from(news));
                    *changed_at = if news { at } else { *changed_at };
                    *jumps = jumps.saturating_sub(u16::from(news));
                    let moves = (at.since(*changed_at) <= frozen_after) | !active;
                    let well = (*jumps < JUMPING) & moves;
                    seen = (seen.0 | news, seen.1 & well);
                    *old = *new;
                }
                seen
            },
        );
        t.last_at[range.clone()].fill(at);
        t.jumped[range.clone()].fill(false);
        for (received, active) in t.received[range].iter_mut().zip(active) {
            *received = received.saturating_add(u32::from(*active));
        }
        seen
    }

    /// Taxel by taxel: whether any changed, and whether all are received, move, and do not jump.
    fn observe_each(&mut self, scan: &Scan, range: Range<usize>, steady: bool) -> (bool, bool) {
        let at = scan.at();
        let (jump, frozen_after) = (self.settings.jump_counts, self.settings.frozen_after);
        let (mut any, mut well) = (false, true);
        let t = &mut self.taxels;
        for i in range {
            if !(self.active[i] && scan.fresh()[i]) {
                well &= !self.active[i];
                continue;
            }
            let (old, new) = (t.counts[i], scan.counts()[i]);
            if t.received[i] == 0 {
                (t.first_at[i], t.changed_at[i]) = (at, at);
                any = true;
            } else if new != old {
                t.changed[i] = t.changed[i].saturating_add(1);
                t.changed_at[i] = at;
                any = true;
                t.jumped[i] = !steady && new.iter().zip(old).any(|(a, b)| a.abs_diff(b) > jump);
                t.jumps[i] = if t.jumped[i] {
                    t.jumps[i].saturating_add(16).min(64)
                } else {
                    t.jumps[i].saturating_sub(1)
                };
            } else {
                t.jumped[i] = false;
            }
            t.counts[i] = new;
            t.last_at[i] = at;
            t.received[i] = t.received[i].saturating_add(1);
            well &= (t.jumps[i] < JUMPING) & (at.since(t.changed_at[i]) <= frozen_after);
        }
        (any, well)
    }

    /// What is wrong with a taxel at `now`; the worst of several.
    pub fn condition(&self, index: usize, now: Instant) -> Condition {
        if !self.active.get(index).is_some_and(|active| *active) {
            return Condition::Inactive;
        }
        let t = &self.taxels;
        let (received, last_at) = (t.received[index] > 0, t.last_at[index]);
        let silent = if received {
            now.since(last_at)
        } else {
            now.since(self.started.unwrap_or(now))
        };
        let used = if self.single_axis[index] { 2.. } else { 0.. };
        let at_an_end = |c: &u16| *c == 0 || *c == u16::MAX;
        if silent > self.settings.dead_after {
            Condition::Dead
        } else if received && last_at.since(t.changed_at[index]) > self.settings.frozen_after {
            Condition::Frozen
        } else if received && t.counts[index][used].iter().any(at_an_end) {
            Condition::Saturated
        } else if t.jumps[index] >= JUMPING {
            Condition::Jumping
        } else {
            Condition::Good
        }
    }

    /// Whether a taxel's newest reading jumped: one such reading is no touch.
    pub fn has_jumped(&self, index: usize) -> bool {
        self.taxels.jumped.get(index).is_some_and(|jumped| *jumped)
    }

    /// Readings of a taxel so far, and when the last one came; `None` if none did.
    pub fn received(&self, index: usize) -> Option<(u32, Instant)> {
        let received = *self.taxels.received.get(index).filter(|n| **n > 0)?;
        Some((received, self.taxels.last_at[index]))
    }

    /// Value changes and readings of a taxel per second, since its first reading; 0 before the second one.
    pub fn rates_hz(&self, index: usize) -> (f32, f32) {
        let t = &self.taxels;
        let Some(received) = t.received.get(index) else {
            return (0.0, 0.0);
        };
        let span = t.last_at[index].since(t.first_at[index]).as_secs_f64();
        if span <= 0.0 {
            return (0.0, 0.0);
        }
        let rate = |n: u32| (f64::from(n) / span) as f32;
        (rate(t.changed[index]), rate(received.saturating_sub(1)))
    }

    /// The summary at `now`; allocates nothing.
    pub fn summary(&mut self, now: Instant) -> HealthSummary {
        let mut s = HealthSummary {
            frames: self.frames,
            repeated: self.repeated,
            ..HealthSummary::default()
        };
        for i in 0..self.active.len() {
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
        let active = (0..self.active.len()).filter(|i| self.active[*i]);
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
