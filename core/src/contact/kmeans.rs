//! Weighted K-means in the plane: seeding (4.4), assignment (4.5, 4.6), update (4.7), stop (4.8).
//!
//! Coordinates lie in separate arrays. Distances are taken as differences first: expanded squares lose all
//! digits in f32. Sums run over points in ascending order in f64, so results are the same on every machine.
//!
//! Ties go to the lowest index. A cluster left empty is moved onto the point that adds most to the cost; if no
//! point is off its centroid there is nothing to gain and it stays, so this ends on duplicates too.

use alloc::vec::Vec;

use crate::random::Stream;

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

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }
}

/// When to stop.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stop {
    /// zeta_C of (4.8), mm: half the summed moves of the centroids at or below which iteration ends.
    pub tolerance: f32,
    /// At most this many updates.
    pub max_iterations: u32,
}

/// How a solve ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Outcome {
    /// Assignment passes made.
    pub iterations: u32,
    /// Whether (4.8) was met, rather than the cap.
    pub converged: bool,
}

#[derive(Clone, Copy, Debug, Default)]
struct Sum {
    w: f64,
    wx: f64,
    wy: f64,
    n: u32,
}

/// Centroids and scratch memory for up to a given number of points and clusters.
#[derive(Clone, Debug)]
pub struct KMeans {
    most_points: usize,
    most_clusters: usize,
    cx: Vec<f32>,
    cy: Vec<f32>,
    sums: Vec<Sum>,
    nearest: Vec<f32>,
    assigned: Vec<u32>,
    previous: Vec<u32>,
}

impl KMeans {
    /// Room for `points` points in `clusters` clusters.
    pub fn new(points: usize, clusters: usize) -> Self {
        Self {
            most_points: points,
            most_clusters: clusters,
            cx: Vec::with_capacity(clusters),
            cy: Vec::with_capacity(clusters),
            sums: Vec::with_capacity(clusters),
            nearest: alloc::vec![0.0; points],
            assigned: alloc::vec![0; points],
            previous: alloc::vec![0; points],
        }
    }

    /// Centroids to start from, mm; those beyond the room made are dropped.
    pub fn set_centroids(&mut self, places: impl Iterator<Item = (f32, f32)>) {
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
    pub fn seed(&mut self, points: Points<'_>, k: usize, stream: &mut Stream) {
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
        let n = points.len().min(self.most_points);
        let mut outcome = Outcome {
            iterations: 0,
            converged: n == 0 || self.cx.is_empty(),
        };
        while !outcome.converged && outcome.iterations < stop.max_iterations.max(1) {
            core::mem::swap(&mut self.assigned, &mut self.previous);
            self.assign(points, n);
            outcome.iterations += 1;
            if outcome.iterations > 1 && self.assigned[..n] == self.previous[..n] {
                outcome.converged = true; // the same members have the same centroids: a move of zero
                break;
            }
            outcome.converged = self.update(points, n) <= stop.tolerance;
        }
        outcome
    }

    /// (4.5), (4.6), eight points at a time: their best distances stay in registers over all centroids.
    fn assign(&mut self, points: Points<'_>, n: usize) {
        const LANES: usize = 8;
        let (x, y) = (&points.x[..n], &points.y[..n]);
        let (near, assigned) = (&mut self.nearest[..n], &mut self.assigned[..n]);
        let mut at = 0;
        while at < n {
            let count = LANES.min(n - at);
            let (mut bx, mut by) = ([0.0f32; LANES], [0.0f32; LANES]);
            bx[..count].copy_from_slice(&x[at..at + count]);
            by[..count].copy_from_slice(&y[at..at + count]);
            let (mut best, mut arg) = ([f32::INFINITY; LANES], [0u32; LANES]);
            for (k, (&cx, &cy)) in self.cx.iter().zip(&self.cy).enumerate() {
                for lane in 0..LANES {
                    let d = square(bx[lane], by[lane], cx, cy);
                    let closer = d < best[lane];
                    best[lane] = if closer { d } else { best[lane] };
                    arg[lane] = if closer { k as u32 } else { arg[lane] };
                }
            }
            near[at..at + count].copy_from_slice(&best[..count]);
            assigned[at..at + count].copy_from_slice(&arg[..count]);
            at += count;
        }
    }

    /// (4.7) with the sum of weights below the line; returns the J of (4.8).
    fn update(&mut self, points: Points<'_>, n: usize) -> f32 {
        self.sums.clear();
        self.sums.resize(self.cx.len(), Sum::default()); // within capacity
        for i in 0..n {
            add(&mut self.sums, &self.assigned, points, i, 1.0);
        }
        for k in 0..self.sums.len() {
            if self.sums[k].n == 0 {
                self.refill(points, n, k);
            }
        }
        let mut moved = 0.0f32;
        for (k, sum) in self.sums.iter().enumerate() {
            if sum.n == 0 {
                continue;
            }
            let (x, y) = if sum.w > 0.0 {
                (sum.wx / sum.w, sum.wy / sum.w)
            } else {
                plain_mean(&self.assigned[..n], points, k as u32)
            };
            let (x, y) = (x as f32, y as f32);
            moved += libm::sqrtf(square(x, y, self.cx[k], self.cy[k]));
            (self.cx[k], self.cy[k]) = (x, y);
        }
        0.5 * moved
    }

    /// Gives the empty cluster `k` the point that costs most where it is; the lowest index of equals.
    fn refill(&mut self, points: Points<'_>, n: usize, k: usize) {
        let mut worst = (0.0f32, None);
        for i in 0..n {
            let cost = points.w[i] * self.nearest[i];
            if cost > worst.0 && self.sums[self.assigned[i] as usize].n > 1 {
                worst = (cost, Some(i));
            }
        }
        if let Some(i) = worst.1 {
            add(&mut self.sums, &self.assigned, points, i, -1.0);
            self.assigned[i] = k as u32;
            self.nearest[i] = 0.0;
            add(&mut self.sums, &self.assigned, points, i, 1.0);
        }
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
        self.sums.get(cluster).map_or(0, |s| s.n)
    }

    /// sum(w d²) of the points to their nearest centroid, mm² times weight.
    pub fn inertia(&self, points: Points<'_>) -> f64 {
        (0..points.len())
            .map(|i| {
                let d = self.centroids().map(|(x, y)| {
                    let dx = f64::from(points.x[i]) - f64::from(x);
                    let dy = f64::from(points.y[i]) - f64::from(y);
                    dx * dx + dy * dy
                });
                f64::from(points.w[i]) * d.fold(f64::INFINITY, f64::min)
            })
            .sum()
    }
}

fn square(ax: f32, ay: f32, bx: f32, by: f32) -> f32 {
    let (dx, dy) = (ax - bx, ay - by);
    dx * dx + dy * dy
}

#[inline]
fn add(sums: &mut [Sum], assigned: &[u32], points: Points<'_>, i: usize, sign: f64) {
    let sum = &mut sums[assigned[i] as usize];
    let w = sign * f64::from(points.w[i]);
    sum.w += w;
    sum.wx += w * f64::from(points.x[i]);
    sum.wy += w * f64::from(points.y[i]);
    sum.n = if sign < 0.0 { sum.n - 1 } else { sum.n + 1 };
}

/// Where all members weigh nothing they weigh the same.
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
