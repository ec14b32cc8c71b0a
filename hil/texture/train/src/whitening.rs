//! Inputs brought to one scale: changes from row to row, equally strong in every direction and independent.
//!
//! A relief shakes each taxel by a few counts, while impact and grip move all of them together by hundreds. The network
//! learns from whitened readings; its first weights then take the whitening into themselves, so that it runs on plain
//! readings as any other.

use burn::backend::NdArray;
use burn::module::Param;
use burn::prelude::*;
use ndarray::{Array1, Array2};

use crate::network::Network;
use crate::recordings::{Recording, Recordings};
use crate::windows::{Scale, Windows};

/// Standard deviation of a whitened change from row to row: slow readings go several times as far.
const GAIN: f64 = 0.3;
/// Variance added to every feature's, as a share of the mean one: a dead feature stays quiet.
const RIDGE: f64 = 1e-3;

/// A linear map of a row, in shares of the features' ranges, and the way back.
pub struct Whitening {
    there: Array2<f64>,
    back: Array2<f64>,
}

impl Whitening {
    /// Whitening of the changes from row to row in these recordings, after their first window, which has the impact.
    pub fn new(windows: &Windows, part: &[usize]) -> Self {
        let features = windows.scale.min.len();
        let mut sum = Array2::<f64>::zeros((features, features));
        let mut change = Array1::<f64>::zeros(features);
        let mut changes = 0usize;
        for &recording in part {
            let rows: Vec<f64> = shares(windows, &windows.recordings.all[recording]).collect();
            let after = rows.chunks_exact(features).skip(windows.length);
            let mut before: Option<&[f64]> = None;
            for row in after {
                if let Some(before) = before {
                    let pairs = change.iter_mut().zip(row.iter().zip(before));
                    pairs.for_each(|(change, (now, before))| *change = now - before);
                    for (mut sums, &one) in sum.rows_mut().into_iter().zip(&change) {
                        sums.scaled_add(one, &change);
                    }
                    changes += 1;
                }
                before = Some(row);
            }
        }
        let mean = sum.diag().sum() / features as f64;
        let ridge = RIDGE * mean.max(f64::MIN_POSITIVE);
        let factor = cholesky((sum + ridge * Array2::<f64>::eye(features)) / changes.max(1) as f64);
        Self {
            there: GAIN * inverse(&factor),
            back: factor / GAIN,
        }
    }

    /// Whitens windows: their ranges are 0 to 1 then.
    pub fn whitened(&self, windows: &Windows) -> Windows {
        let features = windows.scale.min.len();
        let of = |recording: &Recording| {
            let rows: Vec<f64> = shares(windows, recording).collect();
            let first = Array1::from(rows.get(..features).unwrap_or_default().to_vec());
            let row = |row: &[f64]| self.there.dot(&(Array1::from(row.to_vec()) - &first));
            let values = rows.chunks_exact(features).flat_map(row);
            Recording {
                values: values.map(|v| v as f32).collect(),
                ..recording.clone()
            }
        };
        Windows {
            recordings: Recordings {
                columns: windows.recordings.columns.clone(),
                all: windows.recordings.all.iter().map(of).collect(),
            },
            scale: Scale {
                min: vec![0.0; features],
                max: vec![1.0; features],
            },
            length: windows.length,
        }
    }

    /// A network that learned from whitened windows, for plain ones.
    pub fn folded(&self, mut network: Network<NdArray>) -> Network<NdArray> {
        let first = &mut network.encoder[0].weight_ih;
        *first = param(numbers(first.val()).dot(&self.there));
        let dense = &mut network.dense_weight;
        *dense = param(self.back.dot(&numbers(dense.val())));
        let bias: Vec<f32> = (network.dense_bias.val().into_data().into_vec()).expect("in f32");
        let bias = Array1::from_iter(bias.into_iter().map(f64::from));
        let bias: Vec<f32> = self.back.dot(&bias).iter().map(|v| *v as f32).collect();
        network.dense_bias =
            Param::from_data(TensorData::from(bias.as_slice()), &Default::default());
        network
    }
}

/// A recording's readings in shares of their features' ranges, row after row.
fn shares<'a>(windows: &'a Windows, recording: &'a Recording) -> impl Iterator<Item = f64> + 'a {
    let Scale { min, max } = &windows.scale;
    let ranges = min.iter().zip(max).cycle();
    let values = recording.values.iter().zip(ranges);
    values.map(|(v, (min, max))| (f64::from(*v) - f64::from(*min)) / f64::from(max - min))
}

fn numbers(tensor: Tensor<NdArray, 2>) -> Array2<f64> {
    let [rows, columns] = tensor.dims();
    let values: Vec<f32> = tensor.into_data().into_vec().expect("in f32");
    Array2::from_shape_fn((rows, columns), |(r, c)| f64::from(values[r * columns + c]))
}

fn param(matrix: Array2<f64>) -> Param<Tensor<NdArray, 2>> {
    let shape = [matrix.nrows(), matrix.ncols()];
    let values: Vec<f32> = matrix.iter().map(|v| *v as f32).collect();
    Param::from_data(TensorData::new(values, shape), &Default::default())
}

/// The lower triangle whose product with its transpose is this positive matrix.
fn cholesky(mut matrix: Array2<f64>) -> Array2<f64> {
    let count = matrix.nrows();
    for column in 0..count {
        for row in column..count {
            let known: f64 = (0..column)
                .map(|k| matrix[[row, k]] * matrix[[column, k]])
                .sum();
            let left = matrix[[row, column]] - known;
            matrix[[row, column]] = match row == column {
                true => left.max(f64::MIN_POSITIVE).sqrt(),
                false => left / matrix[[column, column]],
            };
            if row > column {
                matrix[[column, row]] = 0.0;
            }
        }
    }
    matrix
}

/// The inverse of a lower triangle.
fn inverse(lower: &Array2<f64>) -> Array2<f64> {
    let count = lower.nrows();
    let mut found = Array2::<f64>::zeros((count, count));
    for column in 0..count {
        for row in column..count {
            let known: f64 = (column..row)
                .map(|k| lower[[row, k]] * found[[k, column]])
                .sum();
            let wanted = if row == column { 1.0 } else { 0.0 };
            found[[row, column]] = (wanted - known) / lower[[row, row]];
        }
    }
    found
}

#[cfg(test)]
#[path = "whitening_tests.rs"]
mod tests;
