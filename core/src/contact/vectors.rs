//! Levels of intensities that are vectors, the second stage as printed, (4.10) to (4.15): K-means++ and K-means in three
//! dimensions.
//!
//! Only on a line has K-means an exact answer that is quick ([`super::levels`]). Here the best of [`DRAWS`] runs counts,
//! each to a fixed point. Draws begin anew with every solve, so that levels follow from the intensities alone.

use alloc::vec::Vec;

use super::levels::{LevelError, check_count};
use crate::random::RandomStream;

/// Runs of K-means, each from seeds of its own.
const DRAWS: usize = 16;
/// Most iterations of a run.
const ITERATIONS: usize = 100;

/// Intensity levels along x, y and z, raw counts; level 1 is the weakest.
#[derive(Clone, Debug, PartialEq)]
pub struct VectorTable(Vec<[f32; 3]>);

impl VectorTable {
    /// The best `k` levels found over a recording's intensities (fewer if they take fewer values).
    ///
    /// # Errors
    /// No level, or more than 65,535; no intensity; one that is no finite number.
    pub fn from_intensities(intensities: &[[f32; 3]], k: usize) -> Result<Self, LevelError> {
        check_count(k, intensities.len())?;
        let mut solver = VectorSolver::new(intensities.len(), k);
        solver.solve(intensities)?;
        Ok(Self(solver.levels))
    }

    /// The level nearest to an intensity, 1 ..= K_I; the weaker of two equally near (4.12). NaN gives 1.
    pub fn level(&self, intensity: [f32; 3]) -> u16 {
        nearest(&self.0, intensity).0 as u16 + 1
    }

    /// All levels, the weakest first, counts.
    pub fn values(&self) -> &[[f32; 3]] {
        &self.0
    }
}

fn square(v: [f64; 3]) -> f64 {
    v[0] * v[0] + v[1] * v[1] + v[2] * v[2]
}

/// Squared Euclidean distance (4.11).
fn distance2(a: [f32; 3], b: [f32; 3]) -> f64 {
    square(core::array::from_fn(|axis| {
        f64::from(a[axis]) - f64::from(b[axis])
    }))
}

/// The nearest level, the first of equally near ones, and its squared distance; 0 where nothing is nearer than infinity.
fn nearest(levels: &[[f32; 3]], intensity: [f32; 3]) -> (usize, f64) {
    let mut best = (0, f64::INFINITY);
    for (index, level) in levels.iter().enumerate() {
        let d = distance2(*level, intensity);
        if d < best.1 {
            best = (index, d);
        }
    }
    best
}

/// K-means of vectors in memory made beforehand.
#[derive(Clone, Debug)]
pub(super) struct VectorSolver {
    most: usize,
    k: usize,
    /// The draws of every solve, from their beginning.
    stream: RandomStream,
    assigned: Vec<usize>,
    centroids: Vec<[f32; 3]>,
    /// Sums of a centroid's vectors, and their number.
    sums: Vec<([f64; 3], u32)>,
    levels: Vec<[f32; 3]>,
}

impl VectorSolver {
    /// Room for `most` vectors and up to `k` levels.
    pub fn new(most: usize, k: usize) -> Self {
        let k = k.min(most);
        Self {
            most,
            k,
            stream: RandomStream::new(0, "levels of vectors"),
            assigned: alloc::vec![0; most],
            centroids: Vec::with_capacity(k),
            sums: Vec::with_capacity(k),
            levels: Vec::with_capacity(k),
        }
    }

    /// Finds the levels of `vectors`. Vectors beyond the room made are dropped.
    pub fn solve(&mut self, vectors: &[[f32; 3]]) -> Result<(), LevelError> {
        self.levels.clear();
        let wild = |v: &[f32; 3]| !v.iter().all(|axis| axis.is_finite());
        if let Some(index) = vectors.iter().position(wild) {
            return Err(LevelError::NotFinite { index });
        }
        let vectors = &vectors[..vectors.len().min(self.most)];
        if vectors.is_empty() || self.k == 0 {
            return Ok(());
        }
        let mut stream = self.stream.clone();
        let mut least = f64::INFINITY;
        for _ in 0..DRAWS {
            self.seed(vectors, &mut stream);
            let cost = self.run(vectors);
            if cost < least {
                least = cost;
                self.levels.clone_from(&self.centroids); // within capacity
            }
        }
        let strength = |v: &[f32; 3]| distance2(*v, [0.0; 3]);
        let by_axis = |a: &[f32; 3], b: &[f32; 3]| {
            let axes = a.iter().zip(b).map(|(a, b)| a.total_cmp(b));
            axes.fold(core::cmp::Ordering::Equal, core::cmp::Ordering::then)
        };
        self.levels
            .sort_unstable_by(|a, b| strength(a).total_cmp(&strength(b)).then(by_axis(a, b)));
        Ok(())
    }

    /// Draws seeds (4.10): the first evenly, each other by its squared distance to the nearest one before. Vectors that
    /// take fewer values give fewer seeds.
    fn seed(&mut self, vectors: &[[f32; 3]], stream: &mut RandomStream) {
        self.centroids.clear();
        let first = (stream.uniform() * vectors.len() as f64) as usize;
        self.centroids.push(vectors[first.min(vectors.len() - 1)]);
        while self.centroids.len() < self.k {
            let far = |v: &[f32; 3]| nearest(&self.centroids, *v).1;
            let mut left = stream.uniform() * vectors.iter().map(far).sum::<f64>();
            let mut drawn = None;
            for v in vectors {
                let d = far(v);
                if d > 0.0 {
                    drawn = Some(*v);
                    left -= d;
                    if left < 0.0 {
                        break;
                    }
                }
            }
            let Some(seed) = drawn else {
                return;
            };
            self.centroids.push(seed);
        }
    }

    /// Alternates (4.12) and (4.13) until no vector changes its level; returns the sum of squared distances.
    fn run(&mut self, vectors: &[[f32; 3]]) -> f64 {
        let mut cost = f64::INFINITY;
        for iteration in 0..ITERATIONS {
            let mut moved = iteration == 0;
            self.sums.clear();
            self.sums.resize(self.centroids.len(), ([0.0; 3], 0)); // within capacity
            cost = 0.0;
            for (v, assigned) in vectors.iter().zip(&mut self.assigned) {
                let (index, d) = nearest(&self.centroids, *v);
                moved |= *assigned != index;
                *assigned = index;
                cost += d;
                let (sum, count) = &mut self.sums[index];
                for (sum, axis) in sum.iter_mut().zip(v) {
                    *sum += f64::from(*axis);
                }
                *count += 1;
            }
            if !moved {
                break;
            }
            for (centroid, (sum, count)) in self.centroids.iter_mut().zip(&self.sums) {
                // A level that lost every vector stays where it is.
                if *count > 0 {
                    *centroid = sum.map(|sum| (sum / f64::from(*count)) as f32);
                }
            }
        }
        cost
    }

    /// The level nearest to an intensity, as [`VectorTable::level`].
    pub fn level(&self, intensity: [f32; 3]) -> u16 {
        nearest(&self.levels, intensity).0 as u16 + 1
    }
}

#[cfg(test)]
#[path = "vectors_tests.rs"]
mod tests;
