//! Knowledge of every taxel, and its update by a scan: mostly many taxels in one go, else taxel by taxel.

use alloc::vec::Vec;
use core::ops::Range;

use super::super::layout::Layout;
use super::super::scan::Scan;
use super::{HealthSettings, JUMPING};
use crate::units::Instant;
use crate::vector::Vectors;

/// All readings but two: both ends, or one end and its neighbour beside the other.
const SPAN: u16 = u16::MAX - 2;

/// Number of scans taken in one go that keep their changes in few bytes per taxel, before they are added up.
const BRIEF: usize = 128;

/// A module's taxels together.
#[derive(Clone, Debug)]
struct Together {
    range: Range<usize>,
    /// Scans that were taken in one go, and the time of the newest: on top of the counts of its taxels.
    scans: u32,
    at: Instant,
    /// Times of those scans whose changes are kept briefly: [`BRIEF`] at most.
    brief: Vec<Instant>,
    /// True if every active taxel was received and none has jumped lately.
    calm: bool,
    /// Time of the newest scan, if every active taxel was in it and well.
    well_at: Option<Instant>,
    /// Time before which no active taxel has last changed.
    moved_at: Instant,
    /// True once the monitor knows whether the skin rests at an end of its range. `rests_at` is that end, if it rests
    /// at one: only skins of one axis do.
    learned: bool,
    rests_at: Option<u16>,
}

/// Taxels with a list per quantity, so that one operation looks at many of them.
#[derive(Clone, Debug)]
pub(super) struct Taxels {
    settings: HealthSettings,
    modules: Vec<Together>,
    /// Each taxel's module.
    module: Vec<u16>,
    pub(super) active: Vec<bool>,
    single_axis: Vec<bool>,
    /// First of [`SPAN`] readings that need no closer look.
    low: Vec<[u16; 3]>,
    /// The newest readings; 0 before the first.
    counts: Vec<[u16; 3]>,
    received: Vec<u32>,
    first_at: Vec<Instant>,
    last_at: Vec<Instant>,
    changed: Vec<u32>,
    changed_at: Vec<Instant>,
    /// Changes in the scans of [`Together::brief`], on top of `changed`. `changed_in` has the number of the last such
    /// scan, from 1; 0 for none.
    lately: Vec<u8>,
    changed_in: Vec<u8>,
    /// Tally of jumps: 16 more for a jump, one less for a quiet reading.
    jumps: Vec<u16>,
    /// True if the newest reading was a jump.
    jumped: Vec<bool>,
    /// Bits by which the scan under inspection differs from the one before, and in `news` a 1 where any of an active
    /// taxel's differ.
    bits: Vec<[u16; 3]>,
    news: Vec<u8>,
    vectors: Vectors,
}

/// Result of looking at a module's scan.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Seen {
    /// True if any taxel changed.
    pub(super) any: bool,
    /// True if every active taxel is in the scan, is well and has not jumped; false says nothing.
    pub(super) well: bool,
}

impl Taxels {
    pub(super) fn new(layout: &Layout, settings: HealthSettings) -> Self {
        let n = layout.taxels();
        let modules = || layout.modules().iter();
        let never = || alloc::vec![Instant::ZERO; n];
        let together = |module: usize| Together {
            range: layout.range(module),
            scans: 0,
            at: Instant::ZERO,
            brief: Vec::with_capacity(BRIEF),
            calm: false,
            well_at: None,
            moved_at: Instant::ZERO,
            learned: layout.modules()[module].axes() != 1,
            rests_at: None,
        };
        let active: Vec<bool> = modules().flat_map(|m| m.active()).copied().collect();
        let single_axis: Vec<bool> = modules()
            .flat_map(|m| m.points().iter().map(move |_| m.axes() == 1))
            .collect();
        // An axis that a taxel does not have reads 0, and one that takes no part may read anything.
        let kinds = || active.iter().zip(&single_axis);
        let low = kinds().map(|(active, single)| match (active, single) {
            (true, true) => [0, 0, 1],
            (true, false) => [1; 3],
            (false, _) => [0; 3],
        });
        Self {
            modules: (0..layout.modules().len()).map(together).collect(),
            module: (0..layout.modules().len())
                .flat_map(|m| layout.range(m).map(move |_| m as u16))
                .collect(),
            low: low.collect(),
            counts: alloc::vec![[0; 3]; n],
            received: alloc::vec![0; n],
            first_at: never(),
            last_at: never(),
            changed: alloc::vec![0; n],
            changed_at: never(),
            lately: alloc::vec![0; n],
            changed_in: alloc::vec![0; n],
            jumps: alloc::vec![0; n],
            jumped: alloc::vec![false; n],
            bits: alloc::vec![[0; 3]; n],
            news: alloc::vec![0; n],
            vectors: Vectors::widest(),
            settings,
            active,
            single_axis,
        }
    }

    /// Returns true if an axis of the newest reading is at an end of its range where the skin does not rest.
    pub(super) fn is_at_an_end(&self, index: usize) -> bool {
        let used = if self.single_axis[index] { 2.. } else { 0.. };
        let rests_at = self.modules[usize::from(self.module[index])].rests_at;
        let ill = |c: &u16| (*c == 0 || *c == u16::MAX) && rests_at != Some(*c);
        self.counts[index][used].iter().any(ill)
    }

    pub(super) fn has_jumped(&self, index: usize) -> bool {
        self.jumped.get(index).is_some_and(|jumped| *jumped)
    }

    pub(super) fn is_jumping(&self, index: usize) -> bool {
        self.jumps[index] >= JUMPING
    }

    /// Readings so far, and the time of the newest.
    pub(super) fn received(&self, index: usize) -> Option<(u32, Instant)> {
        let own = *self.received.get(index).filter(|n| **n > 0)?;
        let together = &self.modules[usize::from(self.module[index])];
        let received = own.saturating_add(together.scans);
        Some((received, self.last_at[index].max(together.at)))
    }

    /// Time at which the reading last became another.
    pub(super) fn changed_at(&self, index: usize) -> Instant {
        let brief = &self.modules[usize::from(self.module[index])].brief;
        let lately = usize::from(self.changed_in[index]).checked_sub(1);
        let lately = lately.and_then(|number| brief.get(number));
        lately.copied().unwrap_or(self.changed_at[index])
    }

    /// Changes so far, and the time of the first reading.
    pub(super) fn changes(&self, index: usize) -> (u32, Instant) {
        let lately = u32::from(self.lately[index]);
        let changed = self.changed[index].saturating_add(lately);
        (changed, self.first_at[index])
    }

    /// Takes a module's scan.
    pub(super) fn observe(&mut self, scan: &Scan, module: usize) -> Seen {
        self.learn(scan, module);
        let steady = self.compare(scan, module);
        let seen = if steady && self.modules[module].calm && self.is_whole(scan, module) {
            self.observe_together(scan, module)
        } else {
            let seen = self.observe_each(scan, module);
            Seen {
                well: seen.well && steady,
                ..seen
            }
        };
        self.modules[module].well_at = seen.well.then(|| scan.at());
        seen
    }

    /// Time of a module's newest scan, if every active taxel was in it and well.
    pub(super) fn well_at(&self, module: usize) -> Option<Instant> {
        self.modules.get(module)?.well_at
    }

    /// Number of modules.
    pub(super) fn modules(&self) -> usize {
        self.modules.len()
    }

    /// Finds out from the first scan of most of a module whether it rests at an end of its range: compensated readings
    /// of 8-bit skins are 0 without a touch. Only skins of one axis do; three zeros are a broken board's.
    fn learn(&mut self, scan: &Scan, module: usize) {
        let range = self.modules[module].range.clone();
        if self.modules[module].learned || range.is_empty() {
            return;
        }
        let active = self.active[range.clone()].iter().filter(|a| **a).count();
        let heard = |i: &usize| self.active[*i] && self.single_axis[*i] && scan.fresh()[*i];
        let heard_of = range.clone().filter(heard).count();
        if 2 * heard_of < active {
            return;
        }
        self.modules[module].learned = true;
        let most = |end: &u16| {
            let there = range.clone().filter(heard);
            let there = there.filter(|i| scan.counts()[*i][2] == *end);
            2 * there.count() > heard_of
        };
        let rests_at = [0, u16::MAX].into_iter().find(most);
        self.modules[module].rests_at = rests_at;
        let low = match rests_at {
            None => return,
            Some(0) => 0,
            Some(_) => u16::MAX - SPAN,
        };
        self.low[range].iter_mut().for_each(|axes| axes[2] = low);
    }

    /// Takes the counts, and notes the bits that differ from before. Returns true if no value jumps and none is at an
    /// end of its range: one look at all of it, without a branch.
    fn compare(&mut self, scan: &Scan, module: usize) -> bool {
        let range = self.modules[module].range.clone();
        let counts = self.counts[range.clone()].as_flattened_mut();
        let now = scan.counts()[range.clone()].as_flattened();
        let low = self.low[range.clone()].as_flattened();
        let step = self.settings.jump_counts;
        let bits = self.bits[range].as_flattened_mut();
        self.vectors.run(
            #[inline(always)]
            || {
                let values = counts.iter_mut().zip(now).zip(low).zip(bits);
                values.fold(true, |all, (((a, b), low), bits)| {
                    let steady = (a.abs_diff(*b) <= step) & (b.wrapping_sub(*low) <= SPAN);
                    (*bits, *a) = (*a ^ b, *b);
                    all & steady
                })
            },
        )
    }

    /// Returns true if every active taxel is in the scan.
    fn is_whole(&self, scan: &Scan, module: usize) -> bool {
        let range = self.modules[module].range.clone();
        let listening = self.active[range.clone()].iter().zip(&scan.fresh()[range]);
        scan.is_whole(module)
            || listening.fold(true, |all, (active, fresh)| all & (!active | fresh))
    }

    /// Observes a calm module that is steady and whole like [`Self::observe_each`], but without a branch.
    fn observe_together(&mut self, scan: &Scan, module: usize) -> Seen {
        let at = scan.at();
        if self.modules[module].brief.len() == BRIEF {
            self.add_up(module);
        }
        let together = &mut self.modules[module];
        together.brief.push(at); // within capacity
        (together.scans, together.at) = (together.scans.saturating_add(1), at);
        let (range, number) = (together.range.clone(), together.brief.len() as u8); // at most BRIEF
        let (bits, active) = (&self.bits[range.clone()], &self.active[range.clone()]);
        let news = &mut self.news[range.clone()];
        let lately = &mut self.lately[range.clone()];
        let changed_in = &mut self.changed_in[range];
        let any = self.vectors.run(
            #[inline(always)]
            || {
                find(bits, active, news);
                count(news, lately, changed_in, number)
            },
        );
        // Taxels only ever change later: a time that was after all of them still is.
        if at.since(together.moved_at) > self.settings.frozen_after {
            self.find_moved(module);
        }
        let still = at.since(self.modules[module].moved_at);
        Seen {
            any,
            well: still <= self.settings.frozen_after,
        }
    }

    /// Adds the changes that were kept briefly to the others.
    fn add_up(&mut self, module: usize) {
        let together = &self.modules[module];
        if together.brief.is_empty() {
            return;
        }
        for i in together.range.clone() {
            self.changed[i] = self.changed[i].saturating_add(u32::from(self.lately[i]));
            if let Some(number) = usize::from(self.changed_in[i]).checked_sub(1) {
                self.changed_at[i] = together.brief[number];
            }
            (self.lately[i], self.changed_in[i]) = (0, 0);
        }
        self.modules[module].brief.clear();
    }

    /// Finds the time since which every active taxel has changed.
    fn find_moved(&mut self, module: usize) {
        self.add_up(module);
        let range = self.modules[module].range.clone();
        let active = range.filter(|i| self.active[*i]);
        let moved_at = active.map(|i| self.changed_at[i]).min();
        self.modules[module].moved_at = moved_at.unwrap_or(Instant::ZERO);
    }

    /// Observes a module taxel by taxel.
    fn observe_each(&mut self, scan: &Scan, module: usize) -> Seen {
        self.add_up(module);
        let at = scan.at();
        let HealthSettings {
            jump_counts,
            frozen_after,
            ..
        } = self.settings;
        let mut seen = Seen {
            any: false,
            well: true,
        };
        let mut calm = true;
        for i in self.modules[module].range.clone() {
            let old = [0, 1, 2].map(|axis| self.counts[i][axis] ^ self.bits[i][axis]);
            if !self.active[i] {
                self.counts[i] = old;
                continue;
            }
            if !scan.fresh()[i] {
                self.counts[i] = old;
                seen.well = false;
                calm &= self.received[i] > 0 && self.jumps[i] == 0 && !self.jumped[i];
                continue;
            }
            let new = self.counts[i];
            if self.received[i] == 0 {
                (self.first_at[i], self.changed_at[i]) = (at, at);
                seen.any = true;
            } else if new != old {
                self.changed[i] = self.changed[i].saturating_add(1);
                self.changed_at[i] = at;
                seen.any = true;
                let jumped = new
                    .iter()
                    .zip(old)
                    .any(|(a, b)| a.abs_diff(b) > jump_counts);
                self.jumped[i] = jumped;
                self.jumps[i] = match jumped {
                    true => self.jumps[i].saturating_add(16).min(64),
                    false => self.jumps[i].saturating_sub(1),
                };
            } else {
                self.jumped[i] = false;
            }
            self.last_at[i] = at;
            self.received[i] = self.received[i].saturating_add(1);
            calm &= self.jumps[i] == 0 && !self.jumped[i];
            seen.well &= self.jumps[i] < JUMPING && at.since(self.changed_at[i]) <= frozen_after;
        }
        self.modules[module].calm = calm;
        self.find_moved(module);
        seen
    }
}

/// Marks active taxels any of whose bits differ with 1. It is a function of slices, so that compilers know that none
/// overlap.
#[inline(always)]
fn find(bits: &[[u16; 3]], active: &[bool], news: &mut [u8]) {
    for ((news, [x, y, z]), active) in news.iter_mut().zip(bits).zip(active) {
        *news = u8::from((x | y | z) != 0) & u8::from(*active);
    }
}

/// Counts the news in scan `number`; returns true if there is any.
#[inline(always)]
fn count(news: &[u8], lately: &mut [u8], changed_in: &mut [u8], number: u8) -> bool {
    let mut any = 0;
    for ((lately, changed_in), news) in lately.iter_mut().zip(changed_in).zip(news) {
        *lately = lately.wrapping_add(*news); // at most BRIEF
        *changed_in = if *news != 0 { number } else { *changed_in };
        any |= news;
    }
    any != 0
}

#[cfg(test)]
#[path = "taxels_tests.rs"]
mod tests;
