//! Weighted K-means in the plane (Lloyd 1982), in fixed memory.
//!
//! Distances are squares of differences, never expanded squares: at raw counts those lose every digit.
//! Ties go to the lowest index, sums run in the order of the points, so a result is the same bits
//! everywhere.

use alloc::boxed::Box;
use alloc::vec;

/// Points as structure of arrays: coordinates in mm and weights above zero.
#[derive(Clone, Copy, Debug)]
pub struct Points<'a> {
    /// Coordinates along x, mm.
    pub x: &'a [f32],
    /// Coordinates along y, mm.
    pub y: &'a [f32],
    /// Weights; not negative.
    pub w: &'a [f32],
}

impl Points<'_> {
    /// How many.
    pub fn len(&self) -> usize {
        self.x.len().min(self.y.len()).min(self.w.len())
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }
}

/// What a run came to.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Outcome {
    /// Iterations made.
    pub iterations: u32,
    /// Whether the centroids came to rest within the limit.
    pub settled: bool,
}

/// Memory of a clustering of at most `points` points into at most `clusters` clusters.
#[derive(Clone, Debug)]
pub struct Workspace {
    /// Centroids along x, mm.
    pub cx: Box<[f32]>,
    /// Centroids along y, mm.
    pub cy: Box<[f32]>,
    /// Cluster of each point.
    pub assignment: Box<[u32]>,
    nearest: Box<[f32]>,
    sums: Box<[[f32; 3]]>,
    members: Box<[u32]>,
}

impl Workspace {
    /// Room for so many points and clusters.
    pub fn new(points: usize, clusters: usize) -> Self {
        Self {
            cx: vec![0.0; clusters].into(),
            cy: vec![0.0; clusters].into(),
            assignment: vec![0; points].into(),
            nearest: vec![0.0; points].into(),
            sums: vec![[0.0; 3]; clusters].into(),
            members: vec![0; clusters].into(),
        }
    }

    /// Members of each cluster after [`Self::run`].
    pub const fn members(&self) -> &[u32] {
        &self.members
    }

    /// Weighted sum of squared distances to the nearest centroid after [`Self::run`], mm².
    pub fn inertia(&self, points: Points<'_>) -> f64 {
        let n = points.len().min(self.nearest.len());
        (0..n)
            .map(|i| f64::from(points.w[i]) * f64::from(self.nearest[i]))
            .sum()
    }

    /// Alternates assignment (4.6) and update (4.7, by the sum of weights) from the centroids in `cx`,
    /// `cy` until half the sum of their moves is at most `zeta` mm (4.8, sign corrected) or `most`
    /// iterations are made. `k` clusters; more points than clusters.
    pub fn run(&mut self, points: Points<'_>, k: usize, zeta: f32, most: u32) -> Outcome {
        let n = points.len().min(self.assignment.len());
        let k = k.min(self.cx.len());
        let (x, y, w) = (&points.x[..n], &points.y[..n], &points.w[..n]);
        let mut outcome = Outcome {
            iterations: 0,
            settled: false,
        };
        if k == 0 {
            return outcome;
        }
        while outcome.iterations < most && !outcome.settled {
            self.assign(x, y, k);
            self.accumulate(x, y, w, k);
            self.fill_empty(x, y, k);
            outcome.settled = self.update(k) <= zeta;
            outcome.iterations += 1;
        }
        outcome
    }

    /// Nearest centroid of every point; the lowest index among equals.
    fn assign(&mut self, x: &[f32], y: &[f32], k: usize) {
        let n = x.len();
        let (nearest, assignment) = (&mut self.nearest[..n], &mut self.assignment[..n]);
        // Cluster by cluster over all points: this loop the compiler turns into vector code.
        let (cx, cy) = (self.cx[0], self.cy[0]);
        for i in 0..n {
            let (dx, dy) = (x[i] - cx, y[i] - cy);
            nearest[i] = dx * dx + dy * dy;
            assignment[i] = 0;
        }
        for c in 1..k {
            let (cx, cy) = (self.cx[c], self.cy[c]);
            for i in 0..n {
                let (dx, dy) = (x[i] - cx, y[i] - cy);
                let d = dx * dx + dy * dy;
                let closer = d < nearest[i];
                nearest[i] = if closer { d } else { nearest[i] };
                assignment[i] = if closer { c as u32 } else { assignment[i] };
            }
        }
    }

    fn accumulate(&mut self, x: &[f32], y: &[f32], w: &[f32], k: usize) {
        self.sums[..k].fill([0.0; 3]);
        self.members[..k].fill(0);
        for i in 0..x.len() {
            let c = self.assignment[i] as usize;
            let sum = &mut self.sums[c];
            sum[0] += w[i] * x[i];
            sum[1] += w[i] * y[i];
            sum[2] += w[i];
            self.members[c] += 1;
        }
    }

    /// A cluster without members takes the point furthest from its own centroid, once per iteration and
    /// cluster. A point that lies on its centroid is left there: moving it would repeat for ever.
    fn fill_empty(&mut self, x: &[f32], y: &[f32], k: usize) {
        for c in 0..k {
            if self.members[c] > 0 {
                continue;
            }
            let mut furthest: Option<usize> = None;
            for i in 0..x.len() {
                let alone = self.members[self.assignment[i] as usize] <= 1;
                let more = furthest.map_or(0.0, |f| self.nearest[f]);
                if !alone && self.nearest[i] > more {
                    furthest = Some(i);
                }
            }
            let Some(i) = furthest else { continue };
            let old = self.assignment[i] as usize;
            self.members[old] -= 1;
            self.members[c] = 1;
            self.assignment[i] = c as u32;
            self.nearest[i] = 0.0;
            // Its weight leaves the old cluster with the next assignment; here it starts the new one.
            self.sums[c] = [x[i], y[i], 1.0];
        }
    }

    /// Moves the centroids; returns half the sum of the distances moved, mm.
    fn update(&mut self, k: usize) -> f32 {
        let mut moved = 0.0;
        for c in 0..k {
            let [sx, sy, sw] = self.sums[c];
            // All weights underflowed, or no point was to be had: the centroid stays.
            if sw <= 0.0 {
                continue;
            }
            let (nx, ny) = (sx / sw, sy / sw);
            let (dx, dy) = (nx - self.cx[c], ny - self.cy[c]);
            (self.cx[c], self.cy[c]) = (nx, ny);
            moved += libm::sqrtf(dx * dx + dy * dy);
        }
        moved / 2.0
    }
}
