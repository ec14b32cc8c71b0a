//! Weighted K-means in the plane: seeding (4.4), assignment (4.5, 4.6), update (4.7), stop (4.8).
//!
//! Coordinates lie in separate arrays. Distances are taken as differences first: expanded squares lose all
//! digits in f32. Sums run in f64 in one fixed order (the module `passes`), so results are the same on every machine.
//!
//! Ties go to the lowest index. A cluster left empty is moved onto the point that adds most to the cost; if no
//! point is off its centroid there is nothing to gain and it stays, so this ends on duplicates too.

use alloc::vec::Vec;

use super::passes::{self, Sum, chained, square};
use crate::random::RandomStream;
use crate::vector::Vectors;

/// Points and weights, slices of one length; all finite, weights not negative.
#[derive(Clone, Copy, Debug)]
pub struct Points<'a> {
    /// Millimetres to the right.
    pub x: &'a [f32],
    /// Millimetres up.
    pub y: &'a [f32],
    /// Weights; any scale.
    pub w: &'a [f32],
}

impl Points<'_> {
    /// The number of complete points: the shortest of the three slices.
    pub fn len(&self) -> usize {
        self.x.len().min(self.y.len()).min(self.w.len())
    }

    /// Tells whether there is no point.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }
}

/// Stopping rule of a solve.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stop {
    /// zeta_C of (4.8), mm: half the summed moves of the centroids at or below which iteration ends.
    pub tolerance: f32,
    /// Largest number of updates.
    pub max_iterations: u32,
}

/// Outcome of a solve.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Outcome {
    /// Assignments settled, whether by a pass over the points or known without.
    pub iterations: u32,
    /// Passes over the points made for them.
    pub passes: u32,
    /// `true` where (4.8) was met, `false` where the cap ended the solve.
    pub converged: bool,
    /// `true` where the same points and weights would end at the very same centroids again.
    pub settled: bool,
}

/// Bounds by which assignments are known without looking at the points again.
#[derive(Clone, Copy, Debug)]
struct Bounds {
    /// Lower bound, over all points, of the distance to the second nearest
    /// centroid less that to the nearest, mm; 0 where not measured.
    margin: f32,
    /// Upper bound of any centroid's move since the assignments were made, mm.
    moved: f32,
}

impl Bounds {
    /// Tells whether another pass could change no assignment. Two
    /// distances change by at most what their centroids move.
    fn holds(self) -> bool {
        self.moved <= 0.0 || 2.0 * self.moved * (1.0 + 1e-5) + 1e-12 < self.margin
    }
}

/// Centroids and scratch memory for up to a given number of points and clusters.
#[derive(Clone, Debug)]
pub struct KMeans {
    most_points: usize,
    most_clusters: usize,
    vectors: Vectors,
    /// 0, 1, 2, ...: a vector of one of them is quicker loaded than made of a counter.
    index: Vec<u32>,
    cx: Vec<f32>,
    cy: Vec<f32>,
    sums: Vec<Sum>,
    nearest: Vec<f32>,
    assigned: Vec<u32>,
    previous: Vec<u32>,
    bounds: Option<Bounds>,
}

impl KMeans {
    /// Room for `points` points in `clusters` clusters.
    pub fn new(points: usize, clusters: usize) -> Self {
        Self {
            most_points: points,
            most_clusters: clusters,
            vectors: Vectors::widest(),
            index: (0..clusters as u32).collect(),
            cx: Vec::with_capacity(clusters),
            cy: Vec::with_capacity(clusters),
            sums: Vec::with_capacity(chained(clusters)),
            nearest: alloc::vec![0.0; points],
            assigned: alloc::vec![0; points],
            previous: alloc::vec![0; points],
            bounds: None,
        }
    }

    /// Returns the solver with these vectors; the choice does not change its results.
    #[must_use]
    pub const fn with_vectors(mut self, vectors: Vectors) -> Self {
        self.vectors = vectors;
        self
    }

    /// Centroids to start from, mm; those beyond the room made are dropped.
    pub fn set_centroids(&mut self, places: impl Iterator<Item = (f32, f32)>) {
        self.bounds = None;
        self.cx.clear();
        self.cy.clear();
        for (x, y) in places.take(self.most_clusters) {
            self.cx.push(x);
            self.cy.push(y);
        }
    }

    /// k-means++ (Arthur & Vassilvitskii 2007), weighted: the first seed is drawn in proportion to w, each further
    /// one in proportion to w d²; of `2 + ln k` draws the one that lowers the cost most is kept (their greedy form).
    /// Where every point is a seed already, seeds repeat.
    pub fn seed(&mut self, points: Points<'_>, k: usize, stream: &mut RandomStream) {
        let n = points.len().min(self.most_points);
        self.set_centroids(core::iter::empty());
        if n == 0 {
            return;
        }
        let trials = 2 + libm::log(k.max(1) as f64) as usize;
        for c in 0..k.min(self.most_clusters) {
            let first = c == 0;
            let mass = |near: &[f32], i: usize| {
                let w = f64::from(points.w[i]);
                if first { w } else { w * f64::from(near[i]) }
            };
            let total: f64 = (0..n).map(|i| mass(&self.nearest, i)).sum();
            let mut best = (f64::INFINITY, 0);
            for _ in 0..if first { 1 } else { trials } {
                let mut left = stream.uniform() * total;
                let mut chosen = None;
                for i in 0..n {
                    let m = mass(&self.nearest, i);
                    if m > 0.0 {
                        chosen = Some(i);
                        if left < m {
                            break;
                        }
                        left -= m;
                    }
                }
                // Nothing has mass: all weights zero, or every point is a seed.
                let i = chosen.unwrap_or(c % n);
                let cost: f64 = (0..n)
                    .map(|j| {
                        let d = square(points.x[j], points.y[j], points.x[i], points.y[i]);
                        let d = if first { d } else { d.min(self.nearest[j]) };
                        f64::from(points.w[j]) * f64::from(d)
                    })
                    .sum();
                if cost < best.0 {
                    best = (cost, i);
                }
            }
            let (sx, sy) = (points.x[best.1], points.y[best.1]);
            for j in 0..n {
                let d = square(points.x[j], points.y[j], sx, sy);
                self.nearest[j] = if first { d } else { d.min(self.nearest[j]) };
            }
            self.cx.push(sx);
            self.cy.push(sy);
        }
    }

    /// Lloyd's iteration from the present centroids. Points beyond the room made are not looked at.
    pub fn solve(&mut self, points: Points<'_>, stop: Stop) -> Outcome {
        self.bounds = None;
        self.iterate::<false>(points, stop)
    }

    /// Solves from the last solve's centroids, for the same places in the same order; weights may differ. The result is
    /// that of [`KMeans::solve`] to the bit. Assignments that cannot have changed are not looked for again.
    pub fn resume(&mut self, points: Points<'_>, stop: Stop) -> Outcome {
        self.iterate::<true>(points, stop)
    }

    /// `MARGIN`: measures margins, which makes a pass dearer and saves passes on resting places. Many points have
    /// some that sit between two centroids whatever happens: there is no margin to find.
    fn iterate<const MARGIN: bool>(&mut self, points: Points<'_>, stop: Stop) -> Outcome {
        const MANY: usize = 1024;
        let n = points.len().min(self.most_points);
        let nothing = n == 0 || self.cx.is_empty();
        let mut outcome = Outcome {
            iterations: 0,
            passes: 0,
            converged: nothing,
            settled: nothing,
        };
        while !outcome.converged && outcome.iterations < stop.max_iterations.max(1) {
            let same = if self.bounds.is_some_and(Bounds::holds) {
                true
            } else {
                core::mem::swap(&mut self.assigned, &mut self.previous);
                if MARGIN && n < MANY {
                    self.assign::<true>(points, n);
                } else {
                    self.assign::<false>(points, n);
                }
                outcome.passes += 1;
                self.assigned[..n] == self.previous[..n]
            };
            outcome.iterations += 1;
            if outcome.iterations > 1 && same {
                // The same members have the same centroids: a move of zero.
                (outcome.converged, outcome.settled) = (true, true);
                break;
            }
            let (moved, changed) = self.update(points, n);
            outcome.converged = moved <= stop.tolerance;
            outcome.settled = !changed;
        }
        outcome
    }

    /// (4.5), (4.6).
    fn assign<const MARGIN: bool>(&mut self, points: Points<'_>, n: usize) {
        let (near, assigned) = (&mut self.nearest[..n], &mut self.assigned[..n]);
        let (places, centroids) = (
            (&points.x[..n], &points.y[..n]),
            (&*self.cx, &*self.cy, &*self.index),
        );
        let margin = self.vectors.run(
            #[inline(always)]
            || passes::assign::<MARGIN>(places, centroids, near, assigned),
        );
        self.bounds = Some(Bounds { margin, moved: 0.0 });
    }

    /// (4.7) with the sum of weights below the line; returns the J of (4.8), and whether any centroid is another.
    fn update(&mut self, points: Points<'_>, n: usize) -> (f32, bool) {
        let clusters = self.cx.len();
        self.sums.resize(chained(clusters), [0.0; 4]); // within capacity
        let (assigned, sums) = (&self.assigned[..n], &mut self.sums[..]);
        self.vectors.run(
            #[inline(always)]
            || passes::sum(points.x, points.y, points.w, assigned, sums),
        );
        for k in 0..clusters {
            if self.sums[k][3] < 1.0 {
                self.refill(points, n, k);
            }
        }
        let (mut moved, mut farthest, mut changed) = (0.0f32, 0.0f32, false);
        for k in 0..clusters {
            let [w, wx, wy, members] = self.sums[k];
            if members < 1.0 {
                continue;
            }
            let (x, y) = if w > 0.0 {
                (wx / w, wy / w)
            } else {
                plain_mean(&self.assigned[..n], points, k as u32)
            };
            let (x, y) = (x as f32, y as f32);
            let step = libm::sqrtf(square(x, y, self.cx[k], self.cy[k]));
            (moved, farthest) = (moved + step, farthest.max(step));
            changed |= (x, y) != (self.cx[k], self.cy[k]);
            (self.cx[k], self.cy[k]) = (x, y);
        }
        if let Some(bounds) = &mut self.bounds {
            // A move too small to have a length still is one.
            bounds.moved += farthest + if changed { f32::MIN_POSITIVE } else { 0.0 };
        }
        (0.5 * moved, changed)
    }

    /// Gives the empty cluster `k` the point that costs most where it is; of equal points the one of the lowest index.
    fn refill(&mut self, points: Points<'_>, n: usize, k: usize) {
        let mut worst = (0.0f32, None);
        for i in 0..n {
            let cost = points.w[i] * self.nearest[i];
            if cost > worst.0 && self.sums[self.assigned[i] as usize][3] > 1.0 {
                worst = (cost, Some(i));
            }
        }
        if let Some(i) = worst.1 {
            let point = (points.x[i], points.y[i], points.w[i]);
            let mut taken = [[0.0; 4]];
            passes::add(&mut taken, 0, point);
            for (s, t) in self.sums[self.assigned[i] as usize]
                .iter_mut()
                .zip(taken[0])
            {
                *s -= t;
            }
            self.assigned[i] = k as u32;
            self.nearest[i] = 0.0;
            passes::add(&mut self.sums, k as u32, point);
        }
        self.bounds = None; // an empty cluster's own distance says nothing
    }

    /// Centroids, mm.
    pub fn centroids(&self) -> impl ExactSizeIterator<Item = (f32, f32)> + '_ {
        self.cx.iter().copied().zip(self.cy.iter().copied())
    }

    /// The cluster of every point of the last solve.
    pub fn assigned(&self) -> &[u32] {
        &self.assigned
    }

    /// Members of a cluster after the last solve that moved the centroids.
    pub fn members(&self, cluster: usize) -> u32 {
        let clusters = self.cx.len();
        let sum = self.sums.get(cluster).filter(|_| cluster < clusters);
        sum.map_or(0, |s| s[3] as u32)
    }
}

/// Mean place of the members of cluster `k`, all with the same weight, for a cluster whose members weigh nothing.
fn plain_mean(assigned: &[u32], points: Points<'_>, k: u32) -> (f64, f64) {
    let mut sum = (0.0, 0.0, 0.0f64);
    for (i, _) in assigned.iter().enumerate().filter(|(_, a)| **a == k) {
        sum.0 += f64::from(points.x[i]);
        sum.1 += f64::from(points.y[i]);
        sum.2 += 1.0;
    }
    (sum.0 / sum.2.max(1.0), sum.1 / sum.2.max(1.0))
}

/// The weighted mean of all points (K = 1, closed form); the plain mean if nothing weighs, 0 without points.
pub fn weighted_mean(points: Points<'_>) -> (f32, f32) {
    let mut sum = (0.0f64, 0.0f64, 0.0f64);
    let mut plain = (0.0f64, 0.0f64);
    for i in 0..points.len() {
        let (x, y) = (f64::from(points.x[i]), f64::from(points.y[i]));
        let w = f64::from(points.w[i]);
        sum = (sum.0 + w * x, sum.1 + w * y, sum.2 + w);
        plain = (plain.0 + x, plain.1 + y);
    }
    if sum.2 > 0.0 {
        ((sum.0 / sum.2) as f32, (sum.1 / sum.2) as f32)
    } else {
        let n = points.len().max(1) as f64;
        ((plain.0 / n) as f32, (plain.1 / n) as f32)
    }
}

#[cfg(test)]
#[path = "kmeans_tests.rs"]
mod tests;
