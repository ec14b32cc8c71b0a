//! The rest of the skin as a state: how the reference goes on once it was found, and which taxels are touched.
//!
//! A module's untouched taxels say how all of it drifts, and the touched ones follow that with their own gain. Where none
//! is untouched the drift goes on as it was, and is trusted less with time. A touch
//! begins above the threshold and ends below a lower limit, and strong touches leave something behind for a while.
//! Pressing raises the normal reading, so a reading below its reference is no touch: the reference was too high.

use alloc::vec::Vec;
use core::ops::Range;

use super::reference::Reference;
use super::relative::RelativeFrame;
use super::speakers::{FEWEST, MIDDLE, Speakers};
use super::together::{ENDED, Together, WIDEST};
use crate::units::{Duration, Instant};

/// Time between two corrections of the reference, s: the work is a small part of a frame's.
const EVERY_S: f32 = 0.04;
/// Most time that one frame is evidence of, s: a frame after a gap says little about the gap.
const LONGEST_S: f32 = 0.1;
/// Share of its threshold that a taxel needs while its module is touched.
const RELEASE: f32 = 0.6;
/// Share of a touch's largest value that may stay when it has ended.
const LEFT: f32 = 0.07;
/// Time constant of a taxel's own drift, of the one that is asked for: its rate settles with that one.
const OWN: f32 = 0.4;
/// Time constant with which such a remainder is forgotten, and with which the reference takes it in, s.
const FADE_S: f32 = 1.0;
const QUICK_S: f32 = 0.2;
/// Time constant of a module's common rate, s.
const RATE_S: f32 = 1.5;
/// Time constant with which that rate is trusted while no taxel shows the drift, s.
const TRUSTED_S: f32 = 20.0;
/// Steepest common drift, counts per second.
const STEEPEST: f32 = 60.0;
/// Largest common step that is no touch, counts, and its growth while no taxel is known to be untouched.
const STEP: f32 = 80.0;
const STEP_PER_S: f32 = 25.0;
/// Time in which no second common step is taken, s.
const STEP_REST_S: f32 = 1.0;
/// Share of a difference along which a reading below its reference is no touch.
const BELOW: f32 = 0.7;
/// Share that a taxel's own rate takes of a deviation: critically damped with the share that the reference takes. Learnt while
/// the module drifts by more than so many counts per second.
const STEER: f32 = 0.5;
const SLOWEST: f32 = 1.5;
/// Drift of a module, counts per second, that tells half as much of a taxel's own rate as a steep one.
const EVIDENT: f32 = 3.0;
/// A reading below its reference by more than this share of the touch's strongest one contradicts the touch: skin bulges
/// by a hundredth. For so long, s, and the reference is taken anew.
const CONTRADICTS: f32 = 0.3;
const WRONG_S: f32 = 0.3;
/// Least share of a touch's largest value that a taxel beside it feels.
const SPREADS: f32 = 0.2;
/// Rank of the taxel beside a touch that speaks for its module, as a share: a little below the median, since a touch raises its
/// neighbours.
const BESIDE: f32 = 0.45;
/// Share of a touch's strength by which one that stands still changes at most.
const STILL: f32 = 0.03;

/// State of every taxel beyond its reference: 26 bytes.
#[derive(Clone, Debug)]
pub(super) struct Rest {
    constant_s: f32,
    modules: Vec<Together>,
    /// Contact threshold at rest, and the one in force.
    base: Vec<f32>,
    limits: Vec<f32>,
    /// Counts that the last touch may have left.
    left: Vec<f32>,
    /// Drift of a taxel beyond its module's, as a share of that.
    gains: Vec<[f32; 3]>,
    touched: Vec<bool>,
    /// True if the taxel was below its reference at the last correction.
    under: Vec<bool>,
    followed: Option<Instant>,
    corrections: u32,
    /// Number of times that the reference of a module proved to have been taken while it was touched.
    taken_touched: u32,
    /// A module whose reference was.
    wrong: Option<usize>,
    speakers: Speakers,
}

impl Rest {
    pub(super) fn new(starts: &[u32], constant: Duration) -> Self {
        let n = starts.last().map_or(0, |n| *n as usize);
        let module = |pair: &[u32]| Together::new(pair[0] as usize..pair[1] as usize);
        Self {
            constant_s: constant.as_secs_f64() as f32 * OWN,
            modules: starts.windows(2).map(module).collect(),
            base: alloc::vec![0.0; n],
            limits: alloc::vec![0.0; n],
            left: alloc::vec![0.0; n],
            gains: alloc::vec![[0.0; 3]; n],
            touched: alloc::vec![false; n],
            under: alloc::vec![false; n],
            followed: None,
            corrections: 0,
            taken_touched: 0,
            wrong: None,
            speakers: Speakers::default(),
        }
    }

    /// The contact threshold of every taxel as it is in force.
    pub(super) fn limits(&self) -> &[f32] {
        &self.limits
    }

    /// Number of times that a module's reference proved to have been taken while it was touched.
    pub(super) const fn taken_touched(&self) -> u32 {
        self.taken_touched
    }

    /// True if a taxel is touched.
    pub(super) fn touches(&self, taxel: usize) -> bool {
        self.touched[taxel]
    }

    /// True if a taxel with a difference of so many counts is neither touched nor away from its reference.
    pub(super) fn rests(&self, taxel: usize, magnitude: f32) -> bool {
        !self.touched[taxel] && magnitude <= self.base[taxel]
    }

    /// A module whose reference has to be taken anew.
    pub(super) const fn take_wrong(&mut self) -> Option<usize> {
        self.wrong.take()
    }

    /// Corrections so far.
    pub(super) const fn corrections(&self) -> u32 {
        self.corrections
    }

    /// Takes a frame that repeats the one before: a leap has stayed. Returns whether a taxel waited for that, so that the
    /// frame is another one now.
    pub(super) fn repeat(&mut self) -> bool {
        let waits = self.modules.iter().any(|m| m.waits);
        if !waits {
            self.modules.iter_mut().for_each(|m| m.pending = None);
        }
        waits
    }

    /// Has a module looked at as one that may have another board.
    pub(super) fn doubt(&mut self, module: usize) {
        if let Some(of) = self.modules.get_mut(module) {
            of.doubt = true;
        }
    }

    /// The first module in doubt whose readings are another board's. Those before it are in doubt no more.
    pub(super) fn another_board(
        &mut self,
        reference: &mut Reference,
        frame: &RelativeFrame,
    ) -> Option<usize> {
        let base = &self.base;
        self.modules.iter_mut().position(|of| {
            let doubted = core::mem::replace(&mut of.doubt, false);
            doubted && of.has_another_board(&reference.part(of.range.clone()), frame, base)
        })
    }

    /// Sets the thresholds at rest of some taxels.
    pub(super) fn set(&mut self, range: Range<usize>, thresholds: &[f32]) {
        self.base[range.clone()].copy_from_slice(&thresholds[range]);
        (0..self.modules.len()).for_each(|m| self.renew(m));
    }

    /// Sets the limits of a module that are in force.
    fn renew(&mut self, m: usize) {
        let of = &self.modules[m];
        let share = if of.open { RELEASE } else { 1.0 };
        for i in of.range.clone() {
            self.limits[i] = share * self.base[i] + self.left[i];
        }
    }

    /// Forgets what is known of a module's taxels.
    pub(super) fn forget(&mut self, module: usize) {
        let of = &mut self.modules[module];
        of.rate = [0.0; 3];
        (of.open, of.pending, of.wary, of.waits) = (false, None, false, false);
        (of.unknown_s, of.below, of.wrong_s) = (0.0, 0, 0.0);
        (of.peak, of.strength, of.still_s, of.corrections) = (0.0, 0.0, 0.0, 0);
        let range = of.range.clone();
        self.left[range.clone()].fill(0.0);
        self.gains[range.clone()].fill([0.0; 3]);
        self.touched[range.clone()].fill(false);
        self.under[range].fill(false);
        self.renew(module);
    }

    /// Takes a step that most of a module made together for what it is, a change of temperature, out of the reference.
    /// Returns whether it did: the frame has to be measured again then.
    pub(super) fn step(&mut self, reference: &mut Reference, frame: &RelativeFrame) -> bool {
        let mut stepped = false;
        for m in 0..self.modules.len() {
            let range = self.modules[m].range.clone();
            let of = &self.modules[m];
            let contacts = frame.contacts_of(m);
            // Where no taxel told the drift under a touch, it shows when that touch has ended.
            let has_ended = of.open && of.unknown_s > 0.0 && {
                let strengths = contacts.iter().map(|i| frame.magnitude()[*i as usize]);
                strengths.sum::<f32>() < ENDED * of.peak
            };
            let is_wide = contacts.len() * 5 >= range.len() * 4;
            if range.len() <= FEWEST || !(is_wide || has_ended) {
                continue;
            }
            let common = self.common_away(reference, frame, range.clone(), (MIDDLE, false));
            let Some(common) = common else { continue };
            let size = norm(common);
            let of = &mut self.modules[m];
            let most = match (has_ended, of.open) {
                (true, _) => STEP + STEP_PER_S * of.unknown_s,
                (false, true) => 0.0,
                (false, false) => STEP + STEP * of.unknown_s.min(0.0) / STEP_REST_S,
            };
            if size > most {
                continue;
            }
            let counts = &frame.counts()[range.clone()];
            let usable = &frame.usable()[range.clone()];
            let mut part = reference.part(range);
            let (mut all, mut agree) = (0, 0);
            for i in (0..usable.len()).filter(|i| usable[*i]) {
                let away = part.away(i, counts[i]);
                let off = [0, 1, 2].map(|a| away[a] - common[a]);
                all += 1;
                agree += usize::from(norm(off) <= (0.4 * size).max(10.0));
            }
            if agree * 5 >= all * 4 {
                (0..usable.len()).for_each(|i| part.shift(i, common));
                self.modules[m].unknown_s = -STEP_REST_S;
                stepped = true;
            }
        }
        stepped
    }

    /// Decides which of the taxels beyond their limits are touched; the frame's contacts are those then.
    pub(super) fn decide(&mut self, reference: &mut Reference, frame: &mut RelativeFrame) {
        let mut dropped = false;
        for m in 0..self.modules.len() {
            dropped |= self.decide_module(m, reference, frame);
        }
        if dropped {
            let touched = &self.touched;
            frame.retain_contacts(|i| touched[i as usize]);
        }
    }

    /// Decides as [`Self::decide`] does, for one module; returns whether any taxel beyond its limit is not touched.
    fn decide_module(
        &mut self,
        m: usize,
        reference: &mut Reference,
        frame: &RelativeFrame,
    ) -> bool {
        let contacts = frame.contacts_of(m);
        let of = &mut self.modules[m];
        let gone = of.pending.filter(|p| !contacts.contains(p));
        of.wary |= gone.is_some();
        if contacts.is_empty() && !of.open {
            (of.pending, of.waits) = (None, false);
            return false;
        }
        if let Some(glitch) = gone {
            self.left[glitch as usize] = 0.0;
        }
        // Parts of one length: no look at a taxel has to be checked. Their taxels are counted from the module's first.
        let (range, first) = (of.range.clone(), of.range.start as u32);
        let usable = &frame.usable()[range.clone()];
        let counts = &frame.counts()[range.clone()];
        let (magnitude, base) = (&frame.magnitude()[range.clone()], &self.base[range.clone()]);
        let left = &mut self.left[range.clone()];
        let limits = &mut self.limits[range.clone()];
        let touched = &mut self.touched[range.clone()];
        let reference = reference.part(range);
        let was_open = of.open;
        let local = |i: &u32| (i - first) as usize;
        let pressed = |i: usize| {
            let along = reference.along(2, i, counts[i]);
            along >= 0.0 || -along < BELOW * magnitude[i]
        };
        // A touch is felt by several taxels, comes on slowly, or is there in the next frame too.
        let sudden = |i: &usize| !touched[*i] && magnitude[*i] > 2.0 * base[*i] && pressed(*i);
        let mut leaps = contacts.iter().map(local).filter(sudden);
        let alone = leaps.next().filter(|_| leaps.next().is_none());
        let leaps = alone.filter(|i| {
            let most = SPREADS * magnitude[*i];
            let quiet =
                |j: usize| magnitude[j] < most.max(0.5 * base[j]) || touched[j] || !usable[j];
            let mut others = (0..usable.len()).filter(|j| j != i);
            of.pending != Some(first + *i as u32) && others.all(quiet)
        });
        of.pending = leaps.map(|i| first + i as u32);
        let waits = leaps.filter(|_| of.wary || of.open);
        of.waits = waits.is_some();
        if of.open {
            touched.fill(false);
        }
        let (mut members, mut strength) = (0, 0.0);
        for i in contacts.iter().map(local) {
            if waits != Some(i) && pressed(i) {
                touched[i] = true;
                left[i] = left[i].max(LEFT * magnitude[i]);
                if was_open {
                    limits[i] = RELEASE * base[i] + left[i];
                }
                members += 1;
                strength += magnitude[i];
            }
        }
        of.open = members > 0;
        if of.open && !was_open {
            (of.peak, of.still_s) = (0.0, 0.0);
            (of.recent, of.drifted) = (0.0, 0.0);
        }
        of.peak = of.peak.max(strength);
        if libm::fabsf(strength - of.strength) > STILL * of.peak {
            (of.strength, of.still_s) = (strength, 0.0);
        }
        if of.open != was_open || gone.is_some() {
            self.renew(m);
        }
        members < contacts.len()
    }

    /// Corrects the reference by a frame, where it is time to. Returns whether it did.
    pub(super) fn follow(&mut self, reference: &mut Reference, frame: &RelativeFrame) -> bool {
        let since = |at: Instant| frame.at.since(at).as_secs_f64() as f32;
        let Some(since_s) = self.followed.map(since) else {
            self.followed = Some(frame.at);
            return false;
        };
        if since_s < EVERY_S {
            return false;
        }
        self.followed = Some(frame.at);
        self.corrections = self.corrections.saturating_add(1);
        let dt = since_s.min(LONGEST_S);
        for m in 0..self.modules.len() {
            let common = self.common(m, reference, frame, dt);
            self.correct(m, reference, frame, (common, dt));
        }
        true
    }

    /// Distance that a module drifted together since the last correction, counts along x, y, z.
    fn common(
        &mut self,
        m: usize,
        reference: &mut Reference,
        frame: &RelativeFrame,
        dt: f32,
    ) -> [f32; 3] {
        let range = self.modules[m].range.clone();
        let most = STEEPEST * dt;
        let rank = if self.modules[m].open { BESIDE } else { MIDDLE };
        let common = match range.len() > FEWEST {
            true => self.common_away(reference, frame, range, (rank, true)),
            false => Some([0.0; 3]),
        };
        let of = &mut self.modules[m];
        of.unknown_s = match common {
            Some(_) => (of.unknown_s + dt).min(0.0),
            None => of.unknown_s + dt,
        };
        let Some(common) = common else {
            of.rate = of.rate.map(|rate| rate * (1.0 - dt / TRUSTED_S));
            let drifts = |rate: f32| libm::fabsf(rate) > SLOWEST;
            return of
                .rate
                .map(|rate| if drifts(rate) { rate * dt } else { 0.0 });
        };
        let common = common.map(|c| c.clamp(-most, most));
        for (rate, c) in of.rate.iter_mut().zip(common) {
            *rate += (c / dt - *rate) * (dt / RATE_S);
        }
        common
    }

    /// Corrects the reference of a module's taxels.
    fn correct(
        &mut self,
        m: usize,
        reference: &mut Reference,
        frame: &RelativeFrame,
        (common, dt): ([f32; 3], f32),
    ) {
        let of = &mut self.modules[m];
        of.corrections = of.corrections.saturating_add(1);
        of.note_drift(norm(common), dt);
        let free = !of.open;
        let early = 1.0 / (of.corrections as f32 + 3.0);
        let slow = (dt / (dt + self.constant_s)).max(early);
        let quick = dt / (dt + QUICK_S);
        let (mut below, mut faded) = (false, false);
        let (mut strongest, mut lowest) = (0.0f32, 0.0f32);
        // Parts of one length: no look at a taxel has to be checked.
        let range = of.range.clone();
        let usable = &frame.usable()[range.clone()];
        let counts = &frame.counts()[range.clone()];
        let (magnitude, base) = (&frame.magnitude()[range.clone()], &self.base[range.clone()]);
        let (touched, under) = (&self.touched[range.clone()], &mut self.under[range.clone()]);
        let left = &mut self.left[range.clone()];
        let gains = &mut self.gains[range.clone()];
        let drop = of.has_ended(|i| magnitude[i] - base[i] - left[i], touched);
        let mut reference = reference.part(range);
        for i in 0..usable.len() {
            if !usable[i] {
                continue;
            }
            let drift = [0, 1, 2].map(|a| common[a] * (1.0 + gains[i][a]));
            if touched[i] {
                reference.shift(i, drift);
                strongest = strongest.max(magnitude[i]);
                if drop {
                    left[i] = magnitude[i];
                    faded = true;
                }
                continue;
            }
            let away = reference.away(i, counts[i]);
            let rest = [0, 1, 2].map(|a| away[a] - drift[a]);
            let was_under = core::mem::replace(&mut under[i], -rest[2] > base[i]);
            let is_under = free && was_under && under[i];
            below |= is_under;
            if is_under {
                // A touch was taken for rest; it leaves something behind as others do.
                left[i] = left[i].max(LEFT * -rest[2]);
            }
            if was_under && -rest[2] > 2.0 * base[i] {
                lowest = lowest.max(-rest[2]);
            }
            let (remains, mut hurried) = (left[i], is_under);
            if free && remains > 0.0 {
                let fades = remains * (1.0 - dt / FADE_S);
                left[i] = if fades < 1.0 { 0.0 } else { fades };
                (hurried, faded) = (true, true);
            }
            if !is_under && magnitude[i] > base[i] + remains {
                // Neither at rest nor touched: a single reading says nothing.
                reference.shift(i, drift);
                continue;
            }
            let part = if hurried { quick } else { slow };
            let steps = [0, 1, 2].map(|a| {
                if free && !hurried && libm::fabsf(of.rate[a]) > SLOWEST {
                    let evidence = of.rate[a] * of.rate[a] + EVIDENT * EVIDENT;
                    let learnt = STEER * slow * slow * rest[a] * of.rate[a] / (dt * evidence);
                    gains[i][a] = (gains[i][a] + learnt).clamp(-WIDEST, WIDEST);
                }
                drift[a] + part * rest[a]
            });
            reference.shift(i, steps);
        }
        of.wrong_s = match of.open && lowest > CONTRADICTS * strongest {
            true => of.wrong_s + dt,
            false => 0.0,
        };
        if of.wrong_s > WRONG_S {
            self.wrong = Some(m);
            self.taken_touched = self.taken_touched.saturating_add(1);
        }
        of.below = if below { of.below + 1 } else { 0 };
        if of.below == 3 {
            self.taken_touched = self.taken_touched.saturating_add(1);
        }
        if faded {
            self.renew(m);
        }
    }

    /// Distance from the reference along every axis that a module's taxels have in common: of some of them, or of some that are
    /// at rest, the one of a rank along z and the median along x and y. `None` where too few speak.
    fn common_away(
        &mut self,
        reference: &mut Reference,
        frame: &RelativeFrame,
        range: Range<usize>,
        (rank, at_rest): (f32, bool),
    ) -> Option<[f32; 3]> {
        let (usable, touched) = (&frame.usable()[range.clone()], &self.touched[range.clone()]);
        let (magnitude, base) = (&frame.magnitude()[range.clone()], &self.base[range.clone()]);
        let rests = |i: usize| !touched[i] && magnitude[i] <= base[i];
        let speaks = |i: usize| usable[i] && (!at_rest || rests(i));
        let counts = &frame.counts()[range.clone()];
        let reference = reference.part(range);
        self.speakers.common(&reference, counts, rank, speaks)
    }
}

fn norm(v: [f32; 3]) -> f32 {
    libm::sqrtf(v[0] * v[0] + v[1] * v[1] + v[2] * v[2])
}
