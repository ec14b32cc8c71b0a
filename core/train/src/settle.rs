//! The last layer, solved: what comes out is linear in its weights, so that least squares finds the best ones at once.
//! Gradient steps of a short training are some per cent off them.

use burn::module::Param;
use burn::prelude::*;

use crate::network::Network;
use crate::training::Plain;
use crate::windows::{Place, Windows};

/// Windows that go through the network at a time.
const AT_ONCE: usize = 64;
/// Keeps weights where they are that the windows say nothing of, as a share of the number of rows.
const HOLD: f64 = 1e-8;

/// The network with the dense layer that reconstructs these windows best; every other layer is as it was.
pub fn settle(network: &Network<Plain>, windows: &Windows, places: &[Place]) -> Network<Plain> {
    let device = Default::default();
    let [features, width] = network.dense_weight.dims();
    // With a one for the bias: squares of the inputs, and their products with what is still missing.
    let inputs = width + 1;
    let (mut squares, mut products) = (vec![0.0; inputs * inputs], vec![0.0; inputs * features]);
    let mut rows = 0;
    for some in places.chunks(AT_ONCE) {
        let x = windows.batch::<Plain>(some, &device);
        let states = network.states(network.encode(x.clone()), windows.length);
        let missing = x - network.dense(states.clone());
        let (states, missing) = (values(states), values(missing));
        rows += some.len() * windows.length;
        for (state, missing) in states
            .chunks_exact(width)
            .zip(missing.chunks_exact(features))
        {
            let with_one = || state.iter().copied().chain([1.0]).map(f64::from);
            for (i, a) in with_one().enumerate() {
                let squares = squares[i * inputs..].iter_mut();
                squares.zip(with_one()).for_each(|(s, b)| *s += a * b);
                let products = products[i * features..].iter_mut();
                let missing = missing.iter().map(|m| f64::from(*m));
                products.zip(missing).for_each(|(p, m)| *p += a * m);
            }
        }
    }
    for i in 0..inputs {
        squares[i * inputs + i] += HOLD * rows.max(1) as f64;
    }
    solve(&mut squares, &mut products, inputs);
    let mut weight = values(network.dense_weight.val());
    let mut bias = values(network.dense_bias.val());
    for (f, bias) in bias.iter_mut().enumerate() {
        for (i, weight) in weight[f * width..][..width].iter_mut().enumerate() {
            *weight += products[i * features + f] as f32;
        }
        *bias += products[width * features + f] as f32;
    }
    let mut settled = network.clone();
    settled.dense_weight = Param::from_data(TensorData::new(weight, [features, width]), &device);
    settled.dense_bias = Param::from_data(TensorData::new(bias, [features]), &device);
    settled
}

fn values<const D: usize>(tensor: Tensor<Plain, D>) -> Vec<f32> {
    tensor.into_data().into_vec().expect("training is in f32")
}

/// Replaces the right sides (row-major, one row for each of `n` unknowns) by the solution, by Cholesky's
/// factorisation of the positive definite matrix.
fn solve(matrix: &mut [f64], right: &mut [f64], n: usize) {
    let sides = right.len() / n;
    for i in 0..n {
        for j in 0..=i {
            let sum: f64 = (0..j).map(|k| matrix[i * n + k] * matrix[j * n + k]).sum();
            let left = matrix[i * n + j] - sum;
            matrix[i * n + j] = if i == j {
                left.max(f64::MIN_POSITIVE).sqrt()
            } else {
                left / matrix[j * n + j]
            };
        }
    }
    for side in 0..sides {
        for i in 0..n {
            let sum: f64 = (0..i)
                .map(|k| matrix[i * n + k] * right[k * sides + side])
                .sum();
            right[i * sides + side] = (right[i * sides + side] - sum) / matrix[i * n + i];
        }
        for i in (0..n).rev() {
            let later = i + 1..n;
            let sum: f64 = later
                .map(|k| matrix[k * n + i] * right[k * sides + side])
                .sum();
            right[i * sides + side] = (right[i * sides + side] - sum) / matrix[i * n + i];
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn equations_are_solved() {
        // 4 2 1 / 2 5 3 / 1 3 6 times (1, -2, 3) and (0, 1, 1)
        let mut matrix = vec![4.0, 2.0, 1.0, 2.0, 5.0, 3.0, 1.0, 3.0, 6.0];
        let mut right = vec![3.0, 3.0, 1.0, 8.0, 13.0, 9.0];
        solve(&mut matrix, &mut right, 3);
        for (found, expected) in right.iter().zip([1.0, 0.0, -2.0, 1.0, 3.0, 1.0]) {
            assert!((found - expected).abs() < 1e-12, "{right:?}");
        }
    }
}
