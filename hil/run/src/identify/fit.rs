//! Least squares by Levenberg and Marquardt, with the intervals of the linearised fit.

// Indices name rows and columns, several arrays of them at once.
#![allow(clippy::needless_range_loop)]

/// Student's t for 95 % and many degrees of freedom.
const T_95: f64 = 1.96;
/// Step of a difference, as a part of a value or of a hundredth of its range.
const STEP: f64 = 1e-5;
/// Relative change of the sum of squares that ends a search.
const DONE: f64 = 1e-7;

/// A trace, and a model of values in their ranges.
pub(super) struct Problem<'a> {
    pub(super) model: &'a dyn Fn(&[f64]) -> Option<Vec<f64>>,
    pub(super) trace: &'a [f64],
    pub(super) ranges: &'a [(f64, f64)],
}

/// Point of a search: the figures' values and the squared error there.
#[derive(Clone, Debug)]
pub(super) struct Place {
    pub(super) values: Vec<f64>,
    /// Sum of the squares of the model's errors.
    pub(super) squares: f64,
    missed: Vec<f64>,
}

/// The normal equations at a place: products of derivatives, and of derivatives with errors.
struct Normal {
    products: Vec<Vec<f64>>,
    pull: Vec<f64>,
}

impl Problem<'_> {
    fn place(&self, values: Vec<f64>) -> Option<Place> {
        let course = (self.model)(&values)?;
        let missed: Vec<f64> = self.trace.iter().zip(course).map(|(t, c)| t - c).collect();
        let squares: f64 = missed.iter().map(|m| m * m).sum();
        squares.is_finite().then_some(Place {
            values,
            squares,
            missed,
        })
    }

    fn normal(&self, place: &Place) -> Option<Normal> {
        let mut slopes = Vec::with_capacity(place.values.len());
        for (k, &(low, high)) in self.ranges.iter().enumerate() {
            let value = place.values[k];
            let step = STEP * value.abs().max((high - low).min(100.0) / 100.0);
            let (a, b) = ((value - step).max(low), (value + step).min(high));
            let at = |v: f64| {
                let mut values = place.values.clone();
                values[k] = v;
                (self.model)(&values)
            };
            let (before, after) = (at(a)?, at(b)?);
            let slope = before.iter().zip(after).map(|(p, q)| (q - p) / (b - a));
            slopes.push(slope.collect::<Vec<f64>>());
        }
        let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(x, y)| x * y).sum::<f64>();
        let row = |a: &Vec<f64>| slopes.iter().map(|b| dot(a, b)).collect();
        Some(Normal {
            products: slopes.iter().map(row).collect(),
            pull: slopes.iter().map(|s| dot(s, &place.missed)).collect(),
        })
    }

    /// Descends from some values, in at most `steps` steps.
    pub(super) fn descend(&self, from: Vec<f64>, steps: usize) -> Option<Place> {
        let mut place = self.place(from)?;
        let mut damping = 1e-3;
        for _ in 0..steps {
            let normal = self.normal(&place)?;
            let before = place.squares;
            // Where no damping helps, this is the bottom.
            while damping < 1e9 {
                let next = normal.step(damping).and_then(|step| {
                    let moved = place.values.iter().zip(step).zip(self.ranges);
                    let values = moved.map(|((v, d), r)| (v + d).clamp(r.0, r.1));
                    self.place(values.collect())
                });
                match next.filter(|next| next.squares <= place.squares) {
                    Some(next) => {
                        (place, damping) = (next, (damping * 0.1).max(1e-12));
                        break;
                    }
                    None => damping *= 10.0,
                }
            }
            if before - place.squares <= DONE * before {
                break;
            }
        }
        Some(place)
    }

    /// Half of the 95 % interval of each value; none where the model does not depend on it, or on it alone.
    pub(super) fn halves(&self, place: &Place) -> Vec<Option<f64>> {
        let count = place.values.len();
        let Some(normal) = self.normal(place) else {
            return vec![None; count];
        };
        let freedom = self.trace.len().saturating_sub(count).max(1) as f64;
        let variance = place.squares / freedom;
        // A figure that changes the trace by less than its noise over its whole range is not in it.
        let shows = |k: &usize| {
            let span = self.ranges[*k].1 - self.ranges[*k].0;
            normal.products[*k][*k] * span * span > variance
        };
        let shown: Vec<usize> = (0..count).filter(shows).collect();
        let row = |i: &usize| shown.iter().map(|j| normal.products[*i][*j]).collect();
        let products: Vec<Vec<f64>> = shown.iter().map(row).collect();
        let half = |k: usize| {
            let place = shown.iter().position(|i| *i == k)?;
            let mut unit = vec![0.0; shown.len()];
            unit[place] = 1.0;
            let inverse = solve(products.clone(), unit)?[place];
            (inverse > 0.0).then(|| T_95 * libm::sqrt(variance * inverse))
        };
        (0..count).map(half).collect()
    }
}

impl Normal {
    fn step(&self, damping: f64) -> Option<Vec<f64>> {
        let mut damped = self.products.clone();
        for (k, row) in damped.iter_mut().enumerate() {
            // A figure without slope stays where it is.
            row[k] = if row[k] > 0.0 {
                row[k] * (1.0 + damping)
            } else {
                1.0
            };
        }
        solve(damped, self.pull.clone())
    }
}

/// Solves symmetric equations by elimination, scaled to a diagonal of ones; none where they have no single solution.
fn solve(mut rows: Vec<Vec<f64>>, mut right: Vec<f64>) -> Option<Vec<f64>> {
    let n = right.len();
    let scale: Vec<f64> = (0..n).map(|k| 1.0 / libm::sqrt(rows[k][k])).collect();
    for i in 0..n {
        for j in 0..n {
            rows[i][j] *= scale[i] * scale[j];
        }
        right[i] *= scale[i];
    }
    for k in 0..n {
        let (done, left) = rows.split_at_mut(k + 1);
        let pivot = &done[k];
        if pivot[k].is_nan() || pivot[k] <= 1e-12 {
            return None;
        }
        for (row, i) in left.iter_mut().zip(k + 1..) {
            let factor = row[k] / pivot[k];
            for (entry, above) in row.iter_mut().zip(pivot).skip(k) {
                *entry -= factor * above;
            }
            right[i] -= factor * right[k];
        }
    }
    for k in (0..n).rev() {
        let known: f64 = (k + 1..n).map(|j| rows[k][j] * right[j]).sum();
        right[k] = (right[k] - known) / rows[k][k];
    }
    for (value, scale) in right.iter_mut().zip(&scale) {
        *value *= scale;
    }
    Some(right)
}
