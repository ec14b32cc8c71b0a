//! The baseline: faulty taxels, the reference frame and the contact threshold, frame by frame.
//!
//! Frame 0 tells faulty taxels, frames 0 ..= T-1 make the reference (the mean), frame T the threshold (4.3);
//! from frame T on relative frames (4.2) are made. The skin must be untouched until then.
//!
//! Beyond the thesis, for boards as they are: a threshold for every taxel from its own noise, a reference that
//! follows slow drift, and a module that starts over after its board was changed.

use alloc::vec::Vec;

use super::layout::Layout;
use super::reference::Reference;
use super::relative::{Axes, FrameError, RelativeFrame};
use super::scan::Scan;
use crate::units::Duration;

/// How the contact threshold is found, raw counts.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ThresholdRule {
    /// The largest |difference| of any chosen axis of any taxel in the first frame after the reference (4.3),
    /// plus a margin.
    Auto {
        /// Added to it, counts.
        margin: f32,
    },
    /// Every taxel its own: `floor` and so many times its noise at rest, measured while the reference is made and
    /// without the rows that merely repeat. One frame with an outlier cannot raise it for all.
    PerTaxel {
        /// Standard deviations (Euclidean over the chosen axes).
        sigmas: f32,
        /// Added to them, counts: what is too faint to matter.
        floor: f32,
    },
    /// As given.
    Fixed {
        /// The threshold, counts.
        counts: f32,
    },
}

/// Settings of the baseline.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BaselineSettings {
    /// T: frames in the reference, at least 1.
    pub reference_frames: u32,
    /// A taxel is faulty when an axis is further than this many standard deviations (over all taxels, population
    /// form) from that axis's mean on the initial frame; `None` keeps all. Over n taxels no value can be further
    /// than sqrt(n - 1) deviations: 3.87 for n = 16.
    pub fault_sigmas: Option<f32>,
    /// The contact threshold.
    pub threshold: ThresholdRule,
    /// The axes that count for threshold, contact and intensity.
    pub axes: Axes,
    /// Time constant with which the reference of a taxel follows its readings while it is not in contact; `None`
    /// keeps it as it was found.
    pub drift: Option<Duration>,
}

impl Default for BaselineSettings {
    /// 10 frames, no taxel faulty, the threshold of (4.3) without margin, all axes, no drift following: the thesis.
    fn default() -> Self {
        Self {
            reference_frames: 10,
            fault_sigmas: None,
            threshold: ThresholdRule::Auto { margin: 0.0 },
            axes: Axes::XYZ,
            drift: None,
        }
    }
}

/// Why settings are refused.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum BaselineError {
    /// T = 0.
    #[error("the reference needs at least one frame")]
    NoReference,
    /// A number of deviations that is not positive and finite.
    #[error("the number of standard deviations must be positive and finite")]
    BadSigmas,
    /// A margin, threshold or number of deviations that is NaN, infinite or negative.
    #[error("threshold and margin must be finite and not negative")]
    BadThreshold,
    /// A time constant of zero.
    #[error("the time constant of drift must be longer than 0")]
    BadDrift,
}

/// Where the baseline stands.
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
    /// Whether a module is starting over.
    restarting: bool,
    active: Vec<bool>,
    usable: Vec<bool>,
    faulty: Vec<bool>,
    single_axis: Vec<bool>,
    thresholds: Vec<f32>,
}

impl Baseline {
    /// A baseline that has seen nothing yet.
    pub fn new(layout: &Layout, settings: BaselineSettings) -> Result<Self, BaselineError> {
        if settings.reference_frames == 0 {
            return Err(BaselineError::NoReference);
        }
        if settings
            .fault_sigmas
            .is_some_and(|k| !(k > 0.0 && k.is_finite()))
        {
            return Err(BaselineError::BadSigmas);
        }
        let (counts, sigmas) = match settings.threshold {
            ThresholdRule::Auto { margin } => (margin, 0.0),
            ThresholdRule::Fixed { counts } => (counts, 0.0),
            ThresholdRule::PerTaxel { sigmas, floor } => (floor, sigmas),
        };
        if [counts, sigmas]
            .iter()
            .any(|v| !(*v >= 0.0 && v.is_finite()))
        {
            return Err(BaselineError::BadThreshold);
        }
        if settings.drift == Some(Duration::ZERO) {
            return Err(BaselineError::BadDrift);
        }
        let n = layout.taxels();
        let modules = || layout.modules().iter();
        let active: Vec<bool> = modules().flat_map(|m| m.active()).copied().collect();
        Ok(Self {
            settings,
            phase: BaselinePhase::Collecting,
            frames: 0,
            starts: layout.starts().to_vec(),
            reference: Reference::new(n, settings.axes.flags()),
            missing: alloc::vec![0; layout.modules().len()],
            restarting: false,
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
                ThresholdRule::PerTaxel { sigmas, floor } => {
                    for (threshold, noise) in self.thresholds.iter_mut().zip(self.reference.noise())
                    {
                        *threshold = floor + sigmas * noise;
                    }
                }
                ThresholdRule::Fixed { .. } => {}
            }
            self.phase = BaselinePhase::Ready;
            return self.phase;
        }
        if self.frames == 0 {
            self.mark_faulty(scan);
        }
        self.reference.collect(scan, 0..n);
        self.frames += 1;
        if self.frames == self.settings.reference_frames {
            self.reference.finish(0..n);
            for (i, usable) in self.usable.iter_mut().enumerate() {
                *usable &= self.reference.knows(i);
            }
            self.phase = BaselinePhase::Referenced;
        }
        // The caller has no relative frame either way; `Referenced` is visible through `phase`.
        self.phase
    }

    /// Starts over with one module, whose board was changed or comes back after a silence: its taxels are left out
    /// until [`Baseline::advance`] has seen as many frames of it as the first reference had. Thresholds stay.
    pub fn restart(&mut self, module: usize) {
        let range = self.range(module);
        if self.phase != BaselinePhase::Ready || range.is_empty() {
            return;
        }
        self.missing[module] = self.settings.reference_frames;
        self.restarting = true;
        self.reference.restart(range.clone());
        self.usable[range].fill(false);
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
            self.missing[module] -= 1;
            if self.missing[module] == 0 {
                self.reference.finish(range.clone());
                for i in range {
                    self.usable[i] = self.active[i] && !self.faulty[i] && self.reference.knows(i);
                }
            }
        }
        self.restarting = self.missing.iter().any(|n| *n > 0);
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
        let n = self.reference.taxels();
        let fits = scan.counts().len() == n && frame.magnitude().len() == n;
        if fits && self.phase == BaselinePhase::Ready && frame.made {
            if frame.is_of(scan) {
                return Ok(false);
            }
            if let Some(constant) = self.settings.drift {
                let since = scan.at().since(frame.at).as_secs_f64() as f32;
                let share = since / (since + constant.as_secs_f64() as f32);
                self.reference.follow(frame, &self.thresholds, share);
            }
        }
        self.measure(scan, frame)
    }

    /// As [`Baseline::advance`] with the reference as it is.
    ///
    /// # Errors
    /// A scan or frame of another layout.
    pub fn relative(&self, scan: &Scan, frame: &mut RelativeFrame) -> Result<bool, FrameError> {
        if self.phase == BaselinePhase::Ready && frame.made && frame.is_of(scan) {
            return Ok(false);
        }
        self.measure(scan, frame)
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
        frame.find_contacts(self.thresholds.iter().copied());
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

    /// Whether a module is starting over.
    #[cfg(target_has_atomic = "ptr")]
    pub(crate) const fn is_restarting(&self) -> bool {
        self.restarting
    }
    /// Whether the reference follows drift.
    pub fn follows_drift(&self) -> bool {
        self.settings.drift.is_some()
    }
    /// Where it stands.
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
