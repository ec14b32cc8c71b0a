//! The baseline: faulty taxels, the reference frame and the contact threshold, frame by frame.
//!
//! Frame 0 tells faulty taxels, frames 0 ..= T-1 make the reference (the mean), frame T the threshold (4.3);
//! from frame T on relative frames (4.2) are made. The skin must be untouched until then.
//!
//! Beyond the thesis, for boards as they are: a threshold for every taxel from its own noise, a reference that is a state
//! (`rest.rs`), and a module that starts over where it was not at rest or its board was changed.

use alloc::vec::Vec;

pub use super::baseline_settings::{BaselineError, BaselineSettings, ThresholdRule};
use super::layout::Layout;
use super::reference::Reference;
use super::relative::{FrameError, RelativeFrame};
use super::rest::Rest;
use super::scan::Scan;
use crate::units::Instant;

/// Motion of a taxel beyond its noise that is allowed while its reference is collected: counts, and counts per second of drift.
const REST_COUNTS: f32 = 10.0;
const STEEPEST: f32 = 30.0;
/// References that are begun before a module does without the taxels that do not come to rest.
const PATIENCE: u32 = 50;
/// Corrections of the reference in which a taxel's noise is still listened to.
const LISTENS: u32 = 257;

/// Phase of the baseline.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BaselinePhase {
    /// Still taking reference frames: no relative frame yet.
    Collecting,
    /// The reference is complete; the next frame finds the threshold.
    Referenced,
    /// Relative frames can be made.
    Ready,
}

/// Finds faulty taxels, reference and threshold, then makes relative frames.
#[derive(Clone, Debug)]
pub struct Baseline {
    settings: BaselineSettings,
    phase: BaselinePhase,
    frames: u32,
    starts: Vec<u32>,
    reference: Reference,
    /// Frames each module still takes for a new reference; 0 once it has one.
    missing: Vec<u32>,
    /// When each module began to take a reference, and frames that it has taken in vain since.
    begun: Vec<Instant>,
    restless: Vec<u32>,
    /// Frames in which a module had not come to rest.
    unrest: u32,
    /// True if a module is starting over.
    restarting: bool,
    /// True while modules start over because they were asked to, and not because they were moved.
    rezeroed: bool,
    rest: Option<Rest>,
    active: Vec<bool>,
    usable: Vec<bool>,
    faulty: Vec<bool>,
    single_axis: Vec<bool>,
    thresholds: Vec<f32>,
}

impl Baseline {
    /// A baseline that has seen nothing yet.
    pub fn new(layout: &Layout, settings: BaselineSettings) -> Result<Self, BaselineError> {
        let (counts, _) = settings.checked()?;
        let n = layout.taxels();
        let of_modules = layout.modules().len();
        let modules = || layout.modules().iter();
        let active: Vec<bool> = modules().flat_map(|m| m.active()).copied().collect();
        Ok(Self {
            settings,
            phase: BaselinePhase::Collecting,
            frames: 0,
            starts: layout.starts().to_vec(),
            reference: Reference::new(n, settings.axes.flags()),
            missing: alloc::vec![0; of_modules],
            begun: alloc::vec![Instant::ZERO; of_modules],
            restless: alloc::vec![0; of_modules],
            unrest: 0,
            restarting: false,
            rezeroed: false,
            rest: settings
                .drift
                .map(|constant| Rest::new(layout.starts(), constant)),
            usable: active.clone(),
            active,
            faulty: alloc::vec![false; n],
            single_axis: modules()
                .flat_map(|m| m.points().iter().map(move |_| m.axes() == 1))
                .collect(),
            thresholds: alloc::vec![counts; n],
        })
    }

    /// Takes the next frame of the whole skin. Taxels not yet seen are left out of the reference, and of the run
    /// if they stay unseen until it is complete. Does nothing once ready; a scan of another layout is ignored.
    pub fn feed(&mut self, scan: &Scan) -> BaselinePhase {
        let n = self.reference.taxels();
        if self.phase == BaselinePhase::Ready || scan.counts().len() != n {
            return self.phase;
        }
        if self.phase == BaselinePhase::Referenced {
            match self.settings.threshold {
                ThresholdRule::Auto { margin } => {
                    let threshold = self.largest_difference(scan) + margin;
                    self.thresholds.fill(threshold);
                }
                ThresholdRule::PerTaxel { .. } => self.weigh_noise(),
                ThresholdRule::Fixed { .. } => {}
            }
            if let Some(rest) = &mut self.rest {
                rest.set(0..n, &self.thresholds);
            }
            self.phase = BaselinePhase::Ready;
            return self.phase;
        }
        if self.frames == 0 {
            self.mark_faulty(scan);
            self.begun.fill(scan.at());
        }
        self.reference.collect(scan, 0..n);
        self.frames += 1;
        if self.frames == self.settings.reference_frames / 2 {
            self.reference.halve(0..n);
        }
        if self.frames == self.settings.reference_frames {
            self.reference.finish(0..n);
            for (i, usable) in self.usable.iter_mut().enumerate() {
                *usable &= self.reference.knows(i);
            }
            self.phase = BaselinePhase::Referenced;
            for module in 0..self.missing.len() {
                if self.is_restless(module, scan.at()) {
                    self.begin(module);
                }
            }
        }
        // The caller has no relative frame either way; `Referenced` is visible through `phase`.
        self.phase
    }

    /// Starts over with one module, whose board was changed or comes back after a silence: its taxels are left out
    /// until [`Baseline::advance`] has seen as many frames of it as the first reference had. Thresholds stay.
    pub fn restart(&mut self, module: usize) {
        if self.phase == BaselinePhase::Ready && !self.range(module).is_empty() {
            self.restless[module] = 0;
            self.begin(module);
            self.fresh_start(module);
        }
    }

    /// Says that a module was silent, and that its board may be another one now: where its next readings show that, the
    /// module starts over. A reference that stays takes no notice.
    pub fn doubt(&mut self, module: usize) {
        if let Some(rest) = &mut self.rest {
            rest.doubt(module);
        }
    }

    /// Takes the reference of every module anew, from the next frame on; nothing is in contact until they have it.
    pub fn rezero(&mut self) {
        (0..self.missing.len()).for_each(|module| self.restart(module));
        self.rezeroed = self.restarting;
    }

    /// Begins a module's reference with its next scan.
    fn begin(&mut self, module: usize) {
        let range = self.range(module);
        self.missing[module] = self.settings.reference_frames;
        self.restarting = true;
        self.reference.restart(range.clone());
        self.usable[range].fill(false);
    }

    fn fresh_start(&mut self, module: usize) {
        if let Some(rest) = &mut self.rest {
            rest.forget(module);
        }
    }

    /// True if a module was moved by more than noise and drift while its reference was collected; where it never comes to
    /// rest, some of its taxels are ill, and those at rest have to do.
    fn is_restless(&mut self, module: usize, now: Instant) -> bool {
        if self.rest.is_none() {
            return false;
        }
        let (range, began) = (self.range(module), self.begun[module]);
        let drift = STEEPEST * now.since(began).as_secs_f64() as f32;
        self.restless[module] =
            self.restless[module].saturating_add(self.settings.reference_frames);
        if !range.clone().any(|i| self.has_moved(i, drift)) {
            self.restless[module] = 0;
            return false;
        }
        if self.restless[module] / self.settings.reference_frames < PATIENCE {
            return true;
        }
        for i in range {
            if self.has_moved(i, drift) {
                (self.faulty[i], self.usable[i]) = (true, false);
            }
        }
        false
    }

    /// True if a taxel that counts moved by more than noise and `drift` counts while its reference was collected.
    fn has_moved(&self, taxel: usize, drift: f32) -> bool {
        self.active[taxel]
            && !self.faulty[taxel]
            && self.reference.knows(taxel)
            && self.reference.moved(taxel, REST_COUNTS + drift)
    }

    /// Sets every taxel's threshold by its noise.
    fn weigh_noise(&mut self) {
        let ThresholdRule::PerTaxel { sigmas, floor } = self.settings.threshold else {
            return;
        };
        self.reference.weigh(floor, sigmas, &mut self.thresholds);
        if let Some(rest) = &mut self.rest {
            rest.set(0..self.thresholds.len(), &self.thresholds);
        }
    }

    fn range(&self, module: usize) -> core::ops::Range<usize> {
        match (self.starts.get(module), self.starts.get(module + 1)) {
            (Some(&from), Some(&to)) => from as usize..to as usize,
            _ => 0..0,
        }
    }

    /// Takes a frame for the modules that start over.
    fn collect_again(&mut self, scan: &Scan) {
        for module in 0..self.missing.len() {
            let range = self.range(module);
            if self.missing[module] == 0 || !scan.fresh()[range.clone()].contains(&true) {
                continue;
            }
            self.reference.collect(scan, range.clone());
            if self.missing[module] == self.settings.reference_frames {
                self.begun[module] = scan.at();
            }
            self.missing[module] -= 1;
            if self.missing[module] == self.settings.reference_frames.div_ceil(2) {
                self.reference.halve(range.clone());
            }
            if self.missing[module] == 0 {
                if self.is_restless(module, scan.at()) {
                    self.begin(module);
                    continue;
                }
                self.reference.finish(range.clone());
                self.fresh_start(module);
                for i in range {
                    self.usable[i] = self.active[i] && !self.faulty[i] && self.reference.knows(i);
                }
                if self.rest.is_some() {
                    self.weigh_noise();
                }
            }
        }
        self.restarting = self.missing.iter().any(|n| *n > 0);
        let was_asked = self.rezeroed && self.restless.iter().all(|n| *n == 0);
        let moved = self.restarting && !was_asked;
        self.unrest = self.unrest.saturating_add(u32::from(moved));
        self.rezeroed &= self.restarting;
    }

    fn mark_faulty(&mut self, scan: &Scan) {
        let Some(k) = self.settings.fault_sigmas else {
            return;
        };
        for axis in 0..3 {
            let takes = |s: &Self, i: usize| {
                s.usable[i] && scan.seen()[i] && (axis == 2 || !s.single_axis[i])
            };
            let values = |s: &Self| {
                let all = scan.counts().iter().enumerate();
                all.filter(|(i, _)| takes(s, *i))
                    .map(|(_, c)| f64::from(c[axis]))
                    .fold((0.0, 0.0), |(n, sum), v| (n + 1.0, sum + v))
            };
            let (n, sum) = values(self);
            if n < 1.0 {
                continue;
            }
            let mean = sum / n;
            let mut squares = 0.0;
            for (i, c) in scan.counts().iter().enumerate() {
                if takes(self, i) {
                    let d = f64::from(c[axis]) - mean;
                    squares += d * d;
                }
            }
            let limit = f64::from(k) * libm::sqrt(squares / n);
            for (i, c) in scan.counts().iter().enumerate() {
                if takes(self, i) && libm::fabs(f64::from(c[axis]) - mean) > limit {
                    self.faulty[i] = true;
                }
            }
        }
        for (usable, faulty) in self.usable.iter_mut().zip(&self.faulty) {
            *usable &= !faulty;
        }
    }

    fn largest_difference(&self, scan: &Scan) -> f32 {
        let mut largest = 0.0f32;
        for (i, counts) in scan.counts().iter().enumerate() {
            for (axis, chosen) in self.settings.axes.flags().into_iter().enumerate() {
                if chosen && self.usable[i] {
                    largest = largest.max(self.reference.difference(axis, i, counts[axis]));
                }
            }
        }
        largest
    }

    /// The relative frame (4.2) of the next scan and its taxels in contact, after the reference has followed drift
    /// up to the scan before. Returns whether anything in the frame may be other than before: the same counts with
    /// the same taxels left out are the same frame, and neither drift nor time changes that.
    ///
    /// Before [`BaselinePhase::Ready`] nothing is in contact. Taxels left out through `frame` stay left out.
    ///
    /// # Errors
    /// A scan or frame of another layout.
    pub fn advance(&mut self, scan: &Scan, frame: &mut RelativeFrame) -> Result<bool, FrameError> {
        if self.restarting && scan.counts().len() == self.reference.taxels() {
            self.collect_again(scan);
        }
        let ready = self.phase == BaselinePhase::Ready;
        if ready && frame.made && frame.magnitude().len() == self.reference.taxels() {
            if frame.is_of(scan) && !self.rest.as_mut().is_some_and(Rest::repeat) {
                return Ok(false);
            }
            self.follow(frame);
        }
        self.measure(scan, frame)?;
        if ready {
            self.decide(scan, frame)?;
        }
        Ok(true)
    }

    /// Has the reference follow the frame of the scan before.
    fn follow(&mut self, frame: &mut RelativeFrame) {
        let Some(rest) = &mut self.rest else {
            return;
        };
        let followed = rest.follow(&mut self.reference, frame);
        if let Some(module) = rest.take_wrong() {
            self.restart(module);
            self.mask(frame);
            return;
        }
        if !followed || rest.corrections() >= LISTENS {
            return;
        }
        for (i, counts) in frame.counts().iter().enumerate() {
            // Readings that leave a wrong reference, and the drift under a touch, are no noise.
            if self.usable[i] && rest.rests(i, frame.magnitude()[i]) {
                self.reference.hear(i, *counts, self.thresholds[i]);
            }
        }
        if rest.corrections().is_power_of_two() {
            self.weigh_noise();
        }
    }

    /// Finds out which taxels of a frame that was measured are touched.
    fn decide(&mut self, scan: &Scan, frame: &mut RelativeFrame) -> Result<(), FrameError> {
        let Some(rest) = &mut self.rest else {
            return Ok(());
        };
        if let Some(module) = rest.another_board(&mut self.reference, frame) {
            self.restart(module);
            self.mask(frame);
            self.measure(scan, frame)?;
        } else if rest.step(&mut self.reference, frame) {
            self.measure(scan, frame)?;
        }
        if let Some(rest) = &mut self.rest {
            rest.decide(&mut self.reference, frame);
        }
        Ok(())
    }

    /// Advances as [`Baseline::advance`] does, with the reference as it is. Where that is a state, the taxels in contact are those of the
    /// newest scan that was advanced to.
    ///
    /// # Errors
    /// A scan or frame of another layout.
    pub fn relative(&self, scan: &Scan, frame: &mut RelativeFrame) -> Result<bool, FrameError> {
        if self.phase == BaselinePhase::Ready && frame.made && frame.is_of(scan) {
            return Ok(false);
        }
        self.measure(scan, frame)?;
        if let Some(rest) = self.rest.as_ref().filter(|_| frame.made) {
            let touched = (0..self.usable.len()).map(|i| rest.touches(i));
            frame.find_contacts(touched.map(|t| if t { -1.0 } else { f32::INFINITY }));
        }
        Ok(true)
    }

    fn measure(&self, scan: &Scan, frame: &mut RelativeFrame) -> Result<bool, FrameError> {
        let n = self.reference.taxels();
        for got in [scan.counts().len(), frame.magnitude().len()] {
            if got != n {
                return Err(FrameError::OtherLayout { got, expected: n });
            }
        }
        if self.phase != BaselinePhase::Ready {
            frame.clear();
            return Ok(true);
        }
        frame.counts.copy_from_slice(scan.counts());
        (frame.at, frame.made) = (scan.at(), true);
        self.reference.measure(&frame.counts, &mut frame.measured);
        frame.spread(self.settings.axes);
        let limits = self
            .rest
            .as_ref()
            .map_or(&self.thresholds[..], Rest::limits);
        frame.find_contacts(limits.iter().copied());
        Ok(true)
    }

    /// A relative frame for this skin, with the taxels found unusable left out. Make it once ready.
    pub fn frame(&self, layout: &Layout) -> RelativeFrame {
        let mut frame = RelativeFrame::new(layout);
        self.mask(&mut frame);
        frame
    }

    /// Leaves the taxels found unusable out of `frame`.
    pub fn mask(&self, frame: &mut RelativeFrame) {
        for (i, usable) in self.usable.iter().enumerate() {
            if !usable {
                frame.set_usable(i, false);
            }
        }
    }

    /// True if a module is starting over.
    pub(crate) const fn is_restarting(&self) -> bool {
        self.restarting
    }

    /// Frames in which a module had no reference because its skin was not at rest.
    pub const fn unrest(&self) -> u32 {
        self.unrest
    }
    /// Number of times that a module's readings fell below its reference without a touch: the skin was touched when it was taken.
    pub fn taken_touched(&self) -> u32 {
        self.rest.as_ref().map_or(0, Rest::taken_touched)
    }
    /// Phase of the baseline.
    pub fn phase(&self) -> BaselinePhase {
        self.phase
    }
    /// The contact threshold, counts, of the taxel with the largest one; final once ready.
    pub fn threshold(&self) -> f32 {
        self.thresholds.iter().copied().fold(0.0, f32::max)
    }
    /// The contact threshold of every taxel, counts; final once ready.
    pub fn thresholds(&self) -> &[f32] {
        &self.thresholds
    }
    /// Faulty taxels (4.3.3).
    pub fn faulty(&self) -> &[bool] {
        &self.faulty
    }
    /// Active, not faulty, and seen while the reference was made.
    pub fn usable(&self) -> &[bool] {
        &self.usable
    }
    /// The reference of a taxel along x, y, z, counts; `None` if there is no such taxel.
    pub fn reference(&self, index: usize) -> Option<[f64; 3]> {
        let along = |axis| self.reference.at(axis, index);
        Some([along(0)?, along(1)?, along(2)?])
    }
}

#[cfg(test)]
#[path = "baseline_tests.rs"]
mod tests;
