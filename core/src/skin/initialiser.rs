//! The initialiser: faulty taxels, the reference frame and the contact threshold, frame by frame.
//!
//! Frame 0 tells faulty taxels, frames 0 ..= T-1 make the reference (the mean), frame T the threshold (4.3);
//! from frame T on relative frames (4.2) are made. The skin must be untouched until then.

use alloc::vec::Vec;
use core::fmt;

use super::frame::Scan;
use super::layout::Layout;
use super::relative::{Axes, FrameError, RelativeFrame};

/// How the contact threshold is found, raw counts.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ThresholdRule {
    /// The largest |difference| of any chosen axis of any taxel in the first frame after the reference (4.3),
    /// plus a margin.
    Auto {
        /// Added to it, counts.
        margin: f32,
    },
    /// As given.
    Fixed {
        /// The threshold, counts.
        counts: f32,
    },
}

/// Settings of the initialiser.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct InitialiserSettings {
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
}

impl Default for InitialiserSettings {
    /// 10 frames, no taxel faulty, the threshold of (4.3) without margin, all axes.
    fn default() -> Self {
        Self {
            reference_frames: 10,
            fault_sigmas: None,
            threshold: ThresholdRule::Auto { margin: 0.0 },
            axes: Axes::XYZ,
        }
    }
}

/// Why settings are refused.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum InitialiserError {
    /// T = 0.
    NoReference,
    /// A number of deviations that is not positive and finite.
    BadSigmas,
    /// A margin or threshold that is NaN, infinite or negative.
    BadThreshold,
}

impl fmt::Display for InitialiserError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::NoReference => "the reference needs at least one frame",
            Self::BadSigmas => "the number of standard deviations must be positive and finite",
            Self::BadThreshold => "threshold and margin must be finite and not negative",
        })
    }
}

impl core::error::Error for InitialiserError {}

/// Where the initialiser stands.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Phase {
    /// Still taking reference frames: no relative frame yet.
    Collecting,
    /// The reference is complete; the next frame finds the threshold.
    Referenced,
    /// Relative frames can be made.
    Ready,
}

/// Finds faulty taxels, reference and threshold, then makes relative frames.
#[derive(Clone, Debug)]
pub struct Initialiser {
    settings: InitialiserSettings,
    phase: Phase,
    frames: u32,
    sums: Vec<[u64; 3]>,
    seen: Vec<u32>,
    /// The reference, split into whole counts and the rest: at 49,000 counts one `f32` is good to 0.002
    /// counts only, while a difference of whole counts is exact.
    reference: [Vec<(f32, f32)>; 3],
    usable: Vec<bool>,
    faulty: Vec<bool>,
    single_axis: Vec<bool>,
    threshold: f32,
}

impl Initialiser {
    /// An initialiser that has seen nothing yet.
    pub fn new(layout: &Layout, settings: InitialiserSettings) -> Result<Self, InitialiserError> {
        if settings.reference_frames == 0 {
            return Err(InitialiserError::NoReference);
        }
        if settings
            .fault_sigmas
            .is_some_and(|k| !(k > 0.0 && k.is_finite()))
        {
            return Err(InitialiserError::BadSigmas);
        }
        let counts = match settings.threshold {
            ThresholdRule::Auto { margin } => margin,
            ThresholdRule::Fixed { counts } => counts,
        };
        if !(counts >= 0.0 && counts.is_finite()) {
            return Err(InitialiserError::BadThreshold);
        }
        let n = layout.taxels();
        let modules = || layout.modules().iter();
        Ok(Self {
            settings,
            phase: Phase::Collecting,
            frames: 0,
            sums: alloc::vec![[0; 3]; n],
            seen: alloc::vec![0; n],
            reference: core::array::from_fn(|_| alloc::vec![(0.0, 0.0); n]),
            usable: modules().flat_map(|m| m.active()).copied().collect(),
            faulty: alloc::vec![false; n],
            single_axis: modules()
                .flat_map(|m| m.points().iter().map(move |_| m.axes() == 1))
                .collect(),
            threshold: counts,
        })
    }

    /// Takes the next frame of the whole skin. Taxels not yet seen are left out of the reference, and of the run
    /// if they stay unseen until it is complete. Does nothing once ready; a scan of another layout is ignored.
    pub fn feed(&mut self, scan: &Scan) -> Phase {
        if self.phase == Phase::Ready || scan.counts().len() != self.sums.len() {
            return self.phase;
        }
        if self.phase == Phase::Referenced {
            if let ThresholdRule::Auto { margin } = self.settings.threshold {
                self.threshold = self.largest_difference(scan) + margin;
            }
            self.phase = Phase::Ready;
            return self.phase;
        }
        if self.frames == 0 {
            self.mark_faulty(scan);
        }
        for (i, counts) in scan.counts().iter().enumerate() {
            if scan.seen()[i] {
                self.seen[i] += 1;
                for (sum, c) in self.sums[i].iter_mut().zip(counts) {
                    *sum += u64::from(*c);
                }
            }
        }
        self.frames += 1;
        if self.frames == self.settings.reference_frames {
            for i in 0..self.sums.len() {
                self.usable[i] &= self.seen[i] > 0;
                for axis in 0..3 {
                    let n = f64::from(self.seen[i].max(1));
                    let mean = self.sums[i][axis] as f64 / n;
                    let whole = libm::floor(mean);
                    self.reference[axis][i] = (whole as f32, (mean - whole) as f32);
                }
            }
            self.phase = Phase::Referenced;
        }
        // The caller has no relative frame either way; `Referenced` is visible through `phase`.
        self.phase
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
                    let (whole, rest) = self.reference[axis][i];
                    let d = libm::fabsf(f32::from(counts[axis]) - whole - rest);
                    largest = largest.max(d);
                }
            }
        }
        largest
    }

    /// The relative frame (4.2) of a scan and its taxels in contact.
    ///
    /// Before [`Phase::Ready`] nothing is in contact. Taxels left out through `frame` stay left out.
    ///
    /// # Errors
    /// A scan or frame of another layout.
    pub fn relative(&self, scan: &Scan, frame: &mut RelativeFrame) -> Result<(), FrameError> {
        let n = self.sums.len();
        for got in [scan.counts().len(), frame.magnitude().len()] {
            if got != n {
                return Err(FrameError::OtherLayout { got, expected: n });
            }
        }
        let flags = self.settings.axes.flags();
        let ready = self.phase == Phase::Ready;
        for axis in 0..3 {
            let out = &mut frame.axes[axis][..n];
            if !(flags[axis] && ready) {
                out.fill(0.0);
                continue;
            }
            let reference = &self.reference[axis][..n];
            for ((out, (whole, rest)), counts) in out.iter_mut().zip(reference).zip(scan.counts()) {
                *out = libm::fabsf(f32::from(counts[axis]) - whole - rest);
            }
        }
        frame.find_contacts(self.threshold);
        Ok(())
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

    /// Where it stands.
    pub fn phase(&self) -> Phase {
        self.phase
    }
    /// The contact threshold, counts; final once ready.
    pub fn threshold(&self) -> f32 {
        self.threshold
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
        let along = |axis: &Vec<(f32, f32)>| {
            axis.get(index)
                .map(|&(whole, rest)| f64::from(whole) + f64::from(rest))
        };
        let [x, y, z] = &self.reference;
        Some([along(x)?, along(y)?, along(z)?])
    }
}

#[cfg(test)]
#[path = "initialiser_tests.rs"]
mod tests;
