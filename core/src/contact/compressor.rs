//! One module's (or one skin's) compression, frame by frame, in fixed memory.

use alloc::boxed::Box;
use alloc::vec;
use alloc::vec::Vec;
use core::fmt;

use crate::random::Stream;
use crate::skin::Module;
use crate::units::Point;

use super::identity::Identities;
use super::intensity::Interpolation;
use super::kmeans::{Points, Workspace};
use super::{levels, seed};

/// Norm l of a weight `||s||_l^p` (4.7).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Norm {
    /// Sum of the axes.
    L1,
    /// Euclidean.
    #[default]
    L2,
    /// Largest axis.
    Linf,
}

/// How a module is compressed.
#[derive(Clone, Debug, PartialEq)]
pub struct Settings {
    /// Most contacts K_C; at least one.
    pub kc: u16,
    /// Exponent p of the weights.
    pub weight_exponent: f32,
    /// Norm l of the weights.
    pub norm: Norm,
    /// Half the sum of centroid moves at which K-means rests, mm (zeta_C of (4.8)).
    pub zeta_mm: f32,
    /// Most iterations a frame.
    pub max_iterations: u32,
    /// Static intensity levels, ascending; empty for one level.
    pub levels: Vec<f32>,
    /// Seed of the k-means++ draws.
    pub seed: u64,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            kc: 1,
            weight_exponent: 2.0,
            norm: Norm::L2,
            zeta_mm: 1e-3,
            max_iterations: 20,
            levels: Vec::new(),
            seed: 0,
        }
    }
}

/// Why there is no compressor.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum CompressError {
    /// K_C is zero.
    NoContacts,
    /// The exponent is not a finite number in 0 ..= 16.
    Exponent(f32),
    /// zeta is not a finite number at or above zero, or no iteration is allowed.
    Stop,
    /// The levels do not ascend, are not finite, or are over 4096.
    Levels,
}

impl fmt::Display for CompressError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NoContacts => write!(f, "expected K_C of at least 1"),
            Self::Exponent(p) => write!(f, "expected a weight exponent of 0 to 16, found {p}"),
            Self::Stop => write!(f, "expected zeta >= 0 mm and at least one iteration"),
            Self::Levels => write!(
                f,
                "expected at most 4096 finite, ascending intensity levels"
            ),
        }
    }
}

impl core::error::Error for CompressError {}

/// A contact of one frame.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Contact {
    /// Identity: stays while the contact does.
    pub id: u32,
    /// Place on the sensor, mm.
    pub place: Point,
    /// Interpolated intensity, raw counts.
    pub intensity: f32,
    /// Intensity level, from 1.
    pub level: u16,
    /// Taxels in its cluster.
    pub members: u16,
}

/// Which way a frame took; what `--explain` counts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stage {
    /// Nothing in contact.
    Idle,
    /// N_C <= K_C: contacts are taxels.
    PassThrough,
    /// K_C = 1: the weighted mean.
    Mean,
    /// K-means from the last frame's centroids, with its iterations.
    Warm(u32),
    /// K-means from k-means++ seeds, with its iterations.
    Cold(u32),
}

/// Compression of one module.
#[derive(Clone, Debug)]
pub struct Compressor {
    settings: Settings,
    taxels: Box<[Point]>,
    interpolation: Interpolation,
    stream: Stream,
    /// Taxels in contact: index, place and weight.
    active: Box<[u32]>,
    x: Box<[f32]>,
    y: Box<[f32]>,
    w: Box<[f32]>,
    scratch: Box<[f32]>,
    work: Workspace,
    who: Identities,
    contacts: Box<[Contact]>,
    count: usize,
    stage: Stage,
}

impl Compressor {
    /// A compressor for one module; `identity` names its random stream.
    ///
    /// # Errors
    /// [`CompressError`] for settings nothing can be compressed with.
    pub fn new(module: &Module, settings: Settings, identity: &str) -> Result<Self, CompressError> {
        if settings.kc == 0 {
            return Err(CompressError::NoContacts);
        }
        if !(0.0..=16.0).contains(&settings.weight_exponent) {
            return Err(CompressError::Exponent(settings.weight_exponent));
        }
        if !(settings.zeta_mm >= 0.0 && settings.zeta_mm.is_finite())
            || settings.max_iterations == 0
        {
            return Err(CompressError::Stop);
        }
        let ascending = settings.levels.windows(2).all(|w| w[0] < w[1]);
        let finite = settings.levels.iter().all(|l| l.is_finite());
        if !(ascending && finite) || settings.levels.len() > 4096 {
            return Err(CompressError::Levels);
        }
        let n = module.taxels().len();
        // More clusters than taxels can never form.
        let k = usize::from(settings.kc).min(n);
        Ok(Self {
            taxels: module.taxels().into(),
            interpolation: Interpolation::of(module),
            stream: Stream::new(settings.seed, identity),
            active: vec![0; n].into(),
            x: vec![0.0; n].into(),
            y: vec![0.0; n].into(),
            w: vec![0.0; n].into(),
            scratch: vec![0.0; n].into(),
            work: Workspace::new(n, k),
            who: Identities::new(k),
            contacts: vec![Contact::default(); k].into(),
            count: 0,
            stage: Stage::Idle,
            settings,
        })
    }

    /// Contacts of the newest frame.
    pub fn contacts(&self) -> &[Contact] {
        &self.contacts[..self.count]
    }

    /// The way the newest frame took.
    pub const fn stage(&self) -> Stage {
        self.stage
    }

    /// The settings.
    pub const fn settings(&self) -> &Settings {
        &self.settings
    }

    /// Compresses a frame. `norms` are Euclidean norms of the relative readings by taxel (raw counts),
    /// `threshold` what they must exceed, `faulty` who takes no part; `axes` gives a taxel's relative
    /// readings where a weight needs them.
    ///
    /// Returns how many taxels are in contact. Values that are not finite are not in contact.
    pub fn compress(
        &mut self,
        norms: &[f32],
        threshold: f32,
        faulty: &[bool],
        axes: impl Fn(usize) -> [f32; 3],
    ) -> usize {
        let n = self.gather(norms, threshold, faulty);
        if n == 0 {
            self.who.clear();
            (self.count, self.stage) = (0, Stage::Idle);
            return 0;
        }
        let k = usize::from(self.settings.kc);
        if n <= k {
            self.stage = Stage::PassThrough;
            self.who.follow(&self.x[..n], &self.y[..n], false);
            for i in 0..n {
                let taxel = self.active[i] as usize;
                let place = Point::new(self.x[i], self.y[i]);
                self.contacts[i] = self.contact(i, place, norms[taxel], 1);
            }
            self.count = n;
            return n;
        }
        self.weigh(n, norms, axes);
        if k == 1 {
            self.mean(n);
        } else {
            self.cluster(n, k);
        }
        for c in 0..k {
            let place = Point::new(self.work.cx[c], self.work.cy[c]);
            let reading = self.interpolation.at(place, &self.taxels, norms, faulty);
            // A neighbour that is not a number spoils the interpolation, never the contact.
            let intensity = if reading.is_finite() { reading } else { 0.0 };
            let members = if k == 1 {
                n
            } else {
                self.work.members()[c] as usize
            };
            self.contacts[c] = self.contact(c, place, intensity, members);
        }
        self.count = k;
        n
    }

    fn contact(&self, i: usize, place: Point, intensity: f32, members: usize) -> Contact {
        Contact {
            id: self.who.id(i),
            place,
            intensity,
            level: levels::assign(&self.settings.levels, intensity),
            members: u16::try_from(members).unwrap_or(u16::MAX),
        }
    }

    /// Collects the taxels in contact; returns how many.
    fn gather(&mut self, norms: &[f32], threshold: f32, faulty: &[bool]) -> usize {
        let mut n = 0;
        for (i, ((&norm, &faulty), place)) in norms.iter().zip(faulty).zip(&self.taxels).enumerate()
        {
            // NaN compares false: it is never in contact.
            if norm > threshold && (0.0..=f32::MAX).contains(&norm) && !faulty {
                self.active[n] = i as u32;
                (self.x[n], self.y[n]) = (place.x, place.y);
                n += 1;
            }
        }
        n
    }

    /// Weights `(||s||_l / max)^p`: scaled by the largest, so that no power overflows; centroids do not
    /// depend on a common factor.
    fn weigh(&mut self, n: usize, norms: &[f32], axes: impl Fn(usize) -> [f32; 3]) {
        for i in 0..n {
            let taxel = self.active[i] as usize;
            self.w[i] = match self.settings.norm {
                Norm::L2 => norms[taxel],
                Norm::L1 => axes(taxel).iter().sum::<f32>().min(f32::MAX),
                Norm::Linf => axes(taxel).iter().fold(0.0, |m, &a| m.max(a)),
            };
        }
        let weights = &mut self.w[..n];
        let largest = weights.iter().fold(0.0f32, |m, &w| m.max(w));
        let p = self.settings.weight_exponent;
        if p <= 0.0 || largest <= 0.0 {
            weights.fill(1.0);
            return;
        }
        // The usual exponents need no logarithm. A quotient: 1 / largest overflows for denormals.
        if (p - 1.0).abs() < f32::EPSILON {
            weights.iter_mut().for_each(|w| *w /= largest);
        } else if (p - 2.0).abs() < f32::EPSILON {
            weights
                .iter_mut()
                .for_each(|w| *w = (*w / largest) * (*w / largest));
        } else {
            weights
                .iter_mut()
                .for_each(|w| *w = libm::powf(*w / largest, p));
        }
    }

    /// K_C = 1: the weighted mean, no iteration.
    fn mean(&mut self, n: usize) {
        let mut sum = [0.0f32; 3];
        for i in 0..n {
            sum[0] += self.w[i] * self.x[i];
            sum[1] += self.w[i] * self.y[i];
            sum[2] += self.w[i];
        }
        // The largest weight is 1, so the sum is never zero.
        (self.work.cx[0], self.work.cy[0]) = (sum[0] / sum[2], sum[1] / sum[2]);
        self.stage = Stage::Mean;
        self.who.follow(
            &self.work.cx[..1],
            &self.work.cy[..1],
            self.who.count() == 1,
        );
    }

    /// Weighted K-means, from the last frame's centroids if there were as many.
    fn cluster(&mut self, n: usize, k: usize) {
        let points = Points {
            x: &self.x[..n],
            y: &self.y[..n],
            w: &self.w[..n],
        };
        let warm = self.who.count() == k;
        if warm {
            let (x, y) = self.who.places();
            self.work.cx.copy_from_slice(x);
            self.work.cy.copy_from_slice(y);
        } else {
            seed::plus_plus(
                points,
                k,
                &mut self.stream,
                &mut self.scratch,
                &mut self.work,
            );
        }
        let outcome = self.work.run(
            points,
            k,
            self.settings.zeta_mm,
            self.settings.max_iterations,
        );
        self.stage = match warm {
            true => Stage::Warm(outcome.iterations),
            false => Stage::Cold(outcome.iterations),
        };
        self.who
            .follow(&self.work.cx[..k], &self.work.cy[..k], warm);
    }
}

#[cfg(test)]
mod tests;
