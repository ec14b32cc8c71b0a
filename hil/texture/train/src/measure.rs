//! Baselines of a trained model: a mean, principal components, nearest neighbours.

use ndarray::{Array1, Array2, Axis};
use palpate_core::random::RandomStream;

use crate::windows::{Place, Windows};

/// Windows as the network sees them, one per row, `[places, length * features]`.
pub fn matrix(windows: &Windows, places: &[Place]) -> Array2<f32> {
    let width = windows.length * windows.recordings.columns.len();
    let mut values = Vec::with_capacity(places.len() * width);
    for &place in places {
        values.extend((0..windows.length).flat_map(|step| windows.scaled(place, step)));
    }
    Array2::from_shape_vec((places.len(), width), values).expect("rows of one length")
}

/// The mean and the leading principal components of some rows.
pub struct Components {
    mean: Array1<f32>,
    /// Orthonormal rows.
    axes: Array2<f32>,
}

impl Components {
    /// Subspace iteration from a seeded start; forty rounds settle components that differ by a tenth in variance.
    pub fn fit(rows: &Array2<f32>, count: usize) -> Self {
        let mean = rows
            .mean_axis(Axis(0))
            .unwrap_or_else(|| Array1::zeros(rows.ncols()));
        let centred = rows - &mean;
        let mut stream = RandomStream::new(1, "principal components");
        let mut axes = Array2::from_shape_fn((count, rows.ncols()), |_| stream.normal() as f32);
        for _ in 0..40 {
            axes = centred.dot(&axes.t()).t().dot(&centred);
            orthonormalise(&mut axes);
        }
        Self { mean, axes }
    }

    /// Coordinates of rows.
    pub fn scores(&self, rows: &Array2<f32>) -> Array2<f32> {
        (rows - &self.mean).dot(&self.axes.t())
    }

    /// Mean squared error of rows after their reduction to the components.
    pub fn error(&self, rows: &Array2<f32>) -> f64 {
        mean_square(&(rows - &self.mean - self.scores(rows).dot(&self.axes)))
    }

    /// Mean squared error of the mean alone.
    pub fn error_of_mean(&self, rows: &Array2<f32>) -> f64 {
        mean_square(&(rows - &self.mean))
    }
}

fn mean_square(values: &Array2<f32>) -> f64 {
    values
        .iter()
        .map(|&v| f64::from(v) * f64::from(v))
        .sum::<f64>()
        / values.len().max(1) as f64
}

/// Gram and Schmidt, row by row.
fn orthonormalise(rows: &mut Array2<f32>) {
    for row in 0..rows.nrows() {
        for earlier in 0..row {
            let other = rows.row(earlier).to_owned();
            let share = rows.row(row).dot(&other);
            rows.row_mut(row).scaled_add(-share, &other);
        }
        let length = rows
            .row(row)
            .dot(&rows.row(row))
            .sqrt()
            .max(f32::MIN_POSITIVE);
        rows.row_mut(row).mapv_inplace(|v| v / length);
    }
}

/// Share of `asked` whose label the `k` nearest of `known` vote for; ties go to the nearest. Coordinates are first
/// brought to the same spread over the known.
pub fn neighbours(known: &[(Vec<f32>, usize)], asked: &[(Vec<f32>, usize)], k: usize) -> f64 {
    let Some(width) = known.first().map(|(z, _)| z.len()) else {
        return 0.0;
    };
    let spread: Vec<f32> = (0..width)
        .map(|c| {
            let column: Array1<f32> = known.iter().map(|(z, _)| z[c]).collect();
            column.std(0.0).max(f32::MIN_POSITIVE)
        })
        .collect();
    let distance = |a: &[f32], b: &[f32]| -> f32 {
        a.iter()
            .zip(b)
            .zip(&spread)
            .map(|((a, b), s)| ((a - b) / s).powi(2))
            .sum()
    };
    let right = asked.iter().filter(|(z, label)| {
        let mut near: Vec<(f32, usize)> = known
            .iter()
            .map(|(other, label)| (distance(z, other), *label))
            .collect();
        near.sort_by(|a, b| a.0.total_cmp(&b.0));
        near.truncate(k);
        let votes = |label: usize| near.iter().filter(|n| n.1 == label).count();
        let most = near.iter().map(|n| votes(n.1)).max().unwrap_or(0);
        near.iter()
            .find(|n| votes(n.1) == most)
            .is_some_and(|n| n.1 == *label)
    });
    right.count() as f64 / asked.len().max(1) as f64
}

/// Added to the sums of squares of standardised coordinates, per recording: keeps those that go together from each other.
const RIDGE: f64 = 1e-3;

/// Share of `asked` that a linear probe labels right: least squares of the known, each label's indicator on the coordinates,
/// and the largest of them.
pub fn linear(known: &[(Vec<f32>, usize)], asked: &[(Vec<f32>, usize)], labels: usize) -> f64 {
    let Some(width) = known.first().map(|(z, _)| z.len()) else {
        return 0.0;
    };
    let count = known.len() as f64;
    let places: Vec<(f64, f64)> = (0..width)
        .map(|c| {
            let column: Array1<f64> = known.iter().map(|(z, _)| f64::from(z[c])).collect();
            (column.sum() / count, column.std(0.0).max(1e-12))
        })
        .collect();
    // Standardised coordinates, and a one.
    let row = |z: &[f32]| -> Vec<f64> {
        let each = z
            .iter()
            .zip(&places)
            .map(|(z, (mean, std))| (f64::from(*z) - mean) / std);
        each.chain([1.0]).collect()
    };
    // Normal equations with the right side of each label, eliminated by rows.
    let n = width + 1;
    let mut system = Array2::<f64>::zeros((n, n + labels));
    for (z, label) in known {
        let row = row(z);
        for (i, a) in row.iter().enumerate() {
            for (j, b) in row.iter().enumerate() {
                system[[i, j]] += a * b;
            }
            system[[i, n + label]] += a;
        }
    }
    for i in 0..n {
        system[[i, i]] += RIDGE * count;
    }
    for i in 0..n {
        // Positive definite: no pivot is 0, and none has to be looked for.
        let pivot = system.row(i).to_owned() / system[[i, i]];
        for other in (0..n).filter(|other| *other != i) {
            let share = system[[other, i]];
            system.row_mut(other).scaled_add(-share, &pivot);
        }
        system.row_mut(i).assign(&pivot);
    }
    let says = |z: &[f32]| -> Option<usize> {
        let row = row(z);
        let score = |label: usize| -> f64 {
            row.iter()
                .enumerate()
                .map(|(i, a)| a * system[[i, n + label]])
                .sum()
        };
        (0..labels).max_by(|a, b| score(*a).total_cmp(&score(*b)))
    };
    let right = asked.iter().filter(|(z, label)| says(z) == Some(*label));
    right.count() as f64 / asked.len().max(1) as f64
}

#[cfg(test)]
#[path = "measure_tests.rs"]
mod tests;
