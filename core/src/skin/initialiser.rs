//! Faulty taxels, the reference frame and the contact threshold (thesis 4.3.3).

use alloc::boxed::Box;
use alloc::vec;
use alloc::vec::Vec;

use super::layout::Module;

/// Which axes of a taxel count.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Axes {
    /// All three.
    #[default]
    Xyz,
    /// The normal axis alone.
    Z,
}

/// Where the contact threshold comes from.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Threshold {
    /// The maximum of the first relative frame over all axes (4.3), and a margin in raw counts.
    Auto {
        /// Added to the maximum.
        margin: f32,
    },
    /// This many raw counts.
    Counts(f32),
}

/// How a module is initialised.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct InitialiserSettings {
    /// Contact-free frames that make the reference; at least one.
    pub reference_frames: u32,
    /// A taxel is faulty if an axis of the first frame lies further than this many standard deviations
    /// from that axis's mean over the module; `None` looks for none.
    pub faulty_sigma: Option<f32>,
    /// The contact threshold.
    pub threshold: Threshold,
    /// Axes whose Euclidean norm is compared with the threshold.
    pub axes: Axes,
}

/// How far the initialiser is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Phase {
    /// Collecting reference frames.
    Reference,
    /// The next frame sets the threshold.
    Threshold,
    /// Frames can be compared with the reference.
    Ready,
}

/// The state of one module's initialisation, and the relative frame it yields afterwards.
#[derive(Clone, Debug)]
pub struct Initialiser {
    settings: InitialiserSettings,
    faulty: Box<[bool]>,
    /// Sum of the reference frames, then their mean.
    reference: Box<[[f32; 3]]>,
    sums: Box<[[u64; 3]]>,
    frames: u32,
    threshold: Option<f32>,
}

impl Initialiser {
    /// For one module; its inactive taxels are faulty from the start.
    pub fn new(settings: InitialiserSettings, module: &Module) -> Self {
        let n = module.taxels().len();
        Self {
            settings,
            faulty: module.active().iter().map(|a| !a).collect(),
            reference: vec![[0.0; 3]; n].into(),
            sums: vec![[0; 3]; n].into(),
            frames: 0,
            threshold: None,
        }
    }

    /// How far it is.
    pub const fn phase(&self) -> Phase {
        match self.threshold {
            Some(_) => Phase::Ready,
            None if self.frames >= self.settings.reference_frames => Phase::Threshold,
            None => Phase::Reference,
        }
    }

    /// The contact threshold in raw counts, once it is known.
    pub const fn threshold(&self) -> Option<f32> {
        self.threshold
    }

    /// Taxels that are left out.
    pub const fn faulty(&self) -> &[bool] {
        &self.faulty
    }

    /// The reference frame, raw counts; zeros before it is known.
    pub const fn reference(&self) -> &[[f32; 3]] {
        &self.reference
    }

    /// Feeds the next frame while not [`Phase::Ready`]; returns the phase the *next* frame meets.
    pub fn feed(&mut self, counts: &[[u16; 3]]) -> Phase {
        match self.phase() {
            Phase::Ready => {}
            Phase::Reference => self.collect(counts),
            Phase::Threshold => self.set_threshold(counts),
        }
        self.phase()
    }

    fn collect(&mut self, counts: &[[u16; 3]]) {
        if self.frames == 0 {
            self.find_faulty(counts);
        }
        for (sum, count) in self.sums.iter_mut().zip(counts) {
            for (s, c) in sum.iter_mut().zip(count) {
                *s += u64::from(*c);
            }
        }
        self.frames += 1;
        if self.frames >= self.settings.reference_frames {
            let n = f64::from(self.frames);
            for (mean, sum) in self.reference.iter_mut().zip(&self.sums) {
                *mean = sum.map(|s| (s as f64 / n) as f32);
            }
            if let Threshold::Counts(counts) = self.settings.threshold {
                self.threshold = Some(counts);
            }
        }
    }

    /// (4.3.3): any axis further than k standard deviations from its mean over the module.
    fn find_faulty(&mut self, counts: &[[u16; 3]]) {
        let Some(k) = self.settings.faulty_sigma else {
            return;
        };
        let operational: Vec<bool> = self.faulty.iter().map(|f| !f).collect(); // once, at the start
        let n = operational.iter().filter(|&&o| o).count().max(1) as f64;
        for axis in 0..3 {
            let values = || {
                let all = counts.iter().zip(&operational).filter(|(_, o)| **o);
                all.map(|(c, _)| f64::from(c[axis]))
            };
            let mean = values().sum::<f64>() / n;
            let deviation = libm::sqrt(values().map(|v| (v - mean) * (v - mean)).sum::<f64>() / n);
            for (faulty, count) in self.faulty.iter_mut().zip(counts) {
                *faulty |= libm::fabs(f64::from(count[axis]) - mean) > f64::from(k) * deviation;
            }
        }
    }

    fn set_threshold(&mut self, counts: &[[u16; 3]]) {
        let Threshold::Auto { margin } = self.settings.threshold else {
            return;
        };
        let mut largest = 0.0f32;
        for (i, count) in counts.iter().enumerate().take(self.reference.len()) {
            if !self.faulty[i] {
                let relative = self.relative(i, *count);
                let axes = if self.settings.axes == Axes::Z {
                    &relative[2..]
                } else {
                    &relative[..]
                };
                largest = axes.iter().fold(largest, |m, &d| m.max(d));
            }
        }
        self.threshold = Some(largest + margin);
    }

    /// Relative reading |G - Gref| per axis (4.2), of a taxel that exists.
    fn relative(&self, taxel: usize, counts: [u16; 3]) -> [f32; 3] {
        let r = self.reference[taxel];
        [0, 1, 2].map(|a| libm::fabsf(f32::from(counts[a]) - r[a]))
    }

    /// Norm of a relative reading over the axes that count; zero for a faulty taxel.
    ///
    /// Fills `norms`, one value a taxel. Both slices must have the module's length; a shorter one limits
    /// what is filled.
    pub fn norms(&self, counts: &[[u16; 3]], norms: &mut [f32]) {
        let taxels = norms
            .iter_mut()
            .zip(counts)
            .zip(&self.reference)
            .zip(&self.faulty);
        match self.settings.axes {
            Axes::Xyz => {
                for (((norm, c), r), &faulty) in taxels {
                    let d = [0, 1, 2].map(|a| f32::from(c[a]) - r[a]);
                    let square = d[0] * d[0] + d[1] * d[1] + d[2] * d[2];
                    *norm = if faulty { 0.0 } else { libm::sqrtf(square) };
                }
            }
            Axes::Z => {
                for (((norm, c), r), &faulty) in taxels {
                    *norm = if faulty {
                        0.0
                    } else {
                        libm::fabsf(f32::from(c[2]) - r[2])
                    };
                }
            }
        }
    }

    /// Relative reading per axis (4.2) of one taxel; zeros for one that does not exist or is faulty.
    pub fn axes_of(&self, taxel: usize, counts: [u16; 3]) -> [f32; 3] {
        if self.faulty.get(taxel).copied().unwrap_or(true) {
            [0.0; 3]
        } else {
            self.relative(taxel, counts)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::layout::Grid;
    use super::*;
    use crate::units::Point;

    fn module() -> Module {
        let grid = Grid {
            rows: 4,
            columns: 4,
            pitch: 4.7,
            centre: Point::default(),
        };
        Module::grid(grid).unwrap()
    }

    fn settings() -> InitialiserSettings {
        InitialiserSettings {
            reference_frames: 2,
            faulty_sigma: None,
            threshold: Threshold::Auto { margin: 1.0 },
            axes: Axes::Xyz,
        }
    }

    #[test]
    fn reference_is_a_mean_and_threshold_the_first_maximum() {
        let mut init = Initialiser::new(settings(), &module());
        assert_eq!(init.feed(&[[100, 200, 300]; 16]), Phase::Reference);
        assert_eq!(init.feed(&[[101, 200, 300]; 16]), Phase::Threshold);
        assert_eq!(init.reference()[7], [100.5, 200.0, 300.0]);
        let mut first = [[100, 200, 300]; 16];
        first[3][1] = 206;
        assert_eq!(init.feed(&first), Phase::Ready);
        assert_eq!(init.threshold(), Some(7.0));
        let mut norms = [0.0; 16];
        first[3] = [100, 204, 303];
        init.norms(&first, &mut norms);
        assert!((norms[3] - (0.25f32 + 16.0 + 9.0).sqrt()).abs() < 1e-6);
        assert_eq!(init.axes_of(3, first[3]), [0.5, 4.0, 3.0]);
    }

    #[test]
    fn one_axis_alone() {
        let settings = InitialiserSettings {
            axes: Axes::Z,
            threshold: Threshold::Counts(5.0),
            ..settings()
        };
        let mut init = Initialiser::new(settings, &module());
        init.feed(&[[100; 3]; 16]);
        assert_eq!(init.feed(&[[100; 3]; 16]), Phase::Ready);
        let mut norms = [0.0; 16];
        init.norms(&[[0, 65535, 90]; 16], &mut norms);
        assert_eq!(norms, [10.0; 16]);
    }

    #[test]
    fn faulty_taxels_are_found_on_the_first_frame_and_left_out() {
        let settings = InitialiserSettings {
            faulty_sigma: Some(3.0),
            ..settings()
        };
        let mut init = Initialiser::new(settings, &module().without(&[15]).unwrap());
        let mut frame = [[1000, 1000, 1000]; 16];
        for (i, taxel) in frame.iter_mut().enumerate() {
            taxel[0] += (i % 3) as u16;
        }
        frame[5][2] = 65535;
        init.feed(&frame);
        let faulty: Vec<usize> = (0..16).filter(|&i| init.faulty()[i]).collect();
        assert_eq!(faulty, [5, 15]);
        init.feed(&frame);
        init.feed(&frame);
        let mut norms = [9.0; 16];
        init.norms(&[[0; 3]; 16], &mut norms);
        assert_eq!((norms[5], norms[15]), (0.0, 0.0));
        assert_eq!(init.axes_of(5, [0; 3]), [0.0; 3]);
        assert_eq!(init.axes_of(99, [0; 3]), [0.0; 3]);
    }

    #[test]
    fn equal_taxels_are_not_faulty() {
        let settings = InitialiserSettings {
            faulty_sigma: Some(3.0),
            ..settings()
        };
        let mut init = Initialiser::new(settings, &module());
        init.feed(&[[500; 3]; 16]);
        assert!(init.faulty().iter().all(|f| !f));
    }
}
