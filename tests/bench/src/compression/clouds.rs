//! Points to cluster: taxels of a grid under presses that wander, and how good a clustering of them is.

use palpate_core::contact::kmeans::{KMeans, Points, Stop};
use palpate_core::random::RandomStream;

/// Frames of a round; presses are back where they were.
pub const ROUND: usize = 40;
/// Starts of which the best counts as the optimum.
const STARTS: usize = 32;

/// The points of one frame.
#[derive(Clone, Debug)]
pub struct Cloud {
    /// mm to the right.
    pub x: Vec<f32>,
    /// mm up.
    pub y: Vec<f32>,
    /// Weights.
    pub w: Vec<f32>,
}

impl Cloud {
    /// `n` taxels of a grid under `k` presses, at `frame` of a round of 400.
    pub fn new(n: usize, k: usize, frame: usize) -> Self {
        let columns = (1..).find(|c| c * c >= n).unwrap_or(1);
        let half = 0.5 * 4.7 * (columns as f64 - 1.0);
        let turn = std::f64::consts::TAU * frame as f64 / 400.0;
        let presses: Vec<(f64, f64)> = (0..k)
            .map(|p| {
                let home = std::f64::consts::TAU * p as f64 / k as f64;
                let reach = 0.7 * half * (0.8 + 0.2 * libm::sin(turn + p as f64));
                let at = home + 0.3 * libm::sin(turn);
                (reach * libm::cos(at), reach * libm::sin(at))
            })
            .collect();
        let place = |i: usize| {
            let (row, column) = (i / columns, i % columns);
            (4.7 * column as f64 - half, half - 4.7 * row as f64)
        };
        let weight = |i: usize| {
            let (x, y) = place(i);
            let near = presses
                .iter()
                .map(|(px, py)| libm::exp(-((x - px) * (x - px) + (y - py) * (y - py)) / 40.0));
            (0.05 + near.sum::<f64>()) as f32
        };
        Self {
            x: (0..n).map(|i| place(i).0 as f32).collect(),
            y: (0..n).map(|i| place(i).1 as f32).collect(),
            w: (0..n).map(weight).collect(),
        }
    }

    /// One round of frames.
    pub fn round(n: usize, k: usize) -> Vec<Self> {
        (0..ROUND).map(|frame| Self::new(n, k, frame)).collect()
    }

    /// Points in the type of K-means.
    pub fn points(&self) -> Points<'_> {
        Points {
            x: &self.x,
            y: &self.y,
            w: &self.w,
        }
    }

    /// sum(w d²) of all points to their nearest centroid: what K-means makes small.
    pub fn inertia(&self, centroids: &[(f64, f64)]) -> f64 {
        let cost = |i: usize| {
            let (x, y) = (f64::from(self.x[i]), f64::from(self.y[i]));
            let d2 = centroids
                .iter()
                .map(|c| (c.0 - x) * (c.0 - x) + (c.1 - y) * (c.1 - y));
            f64::from(self.w[i]) * d2.fold(f64::INFINITY, f64::min)
        };
        (0..self.x.len()).map(cost).sum()
    }

    /// The least inertia found from many starts, each iterated to its end, and from `known` centroids.
    pub fn optimum(&self, k: usize, known: &[(f64, f64)]) -> f64 {
        let mut stream = RandomStream::new(1, "optimum");
        let mut kmeans = KMeans::new(self.x.len(), k);
        let stop = Stop {
            tolerance: 0.0,
            max_iterations: 300,
        };
        let mut best = self.inertia(known);
        for _ in 0..STARTS {
            kmeans.seed(self.points(), k, &mut stream);
            kmeans.solve(self.points(), stop);
            best = best.min(self.inertia(&wide(&kmeans)));
        }
        best
    }
}

/// Centroids in double precision.
pub fn wide(kmeans: &KMeans) -> Vec<(f64, f64)> {
    kmeans
        .centroids()
        .map(|(x, y)| (f64::from(x), f64::from(y)))
        .collect()
}

/// Errors over the frames of a round, summed.
#[derive(Clone, Copy, Debug, Default)]
pub struct Errors {
    excess: f64,
}

impl Errors {
    /// One more frame, whose least inertia is `optimum`.
    pub fn add(&mut self, cloud: &Cloud, centroids: &[(f64, f64)], optimum: f64) {
        self.excess += cloud.inertia(centroids) / optimum - 1.0;
    }

    /// Mean of a round: inertia over the best of many starts, less 1.
    pub fn mean(&self) -> f64 {
        self.excess / ROUND as f64
    }
}
