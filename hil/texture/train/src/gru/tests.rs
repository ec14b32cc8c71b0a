//! The fast layer against the framework's gradient of the plain cell, against numbers in f64, and against differences.

use burn::backend::{Autodiff, NdArray};
use burn::prelude::*;
use palpate_core::random::RandomStream;

use super::{Learning, Recurrent, Weights, by_the_cell};

type Fused = Autodiff<NdArray>;

const SIZE: [usize; 4] = [7, 5, 6, 9]; // steps, batch, inputs, units

fn random<const D: usize>(stream: &mut RandomStream, shape: [usize; D]) -> TensorData {
    let values: Vec<f32> = (0..shape.iter().product())
        .map(|_| 0.6 * stream.normal() as f32)
        .collect();
    TensorData::new(values, shape)
}

fn parts() -> (TensorData, [TensorData; 4]) {
    let mut stream = RandomStream::new(11, "layer");
    let [steps, batch, inputs, units] = SIZE;
    let x = random(&mut stream, [steps, batch, inputs]);
    let ih = random(&mut stream, [3 * units, inputs]);
    let hh = random(&mut stream, [3 * units, units]);
    (
        x,
        [
            ih,
            hh,
            random(&mut stream, [3 * units]),
            random(&mut stream, [3 * units]),
        ],
    )
}

/// Output and the gradients of a loss that weighs every hidden state differently.
fn gradients<L: Learning>(
    layer: fn(Tensor<L, 3>, Weights<L>) -> Tensor<L, 3>,
) -> (Vec<f32>, Vec<Vec<f32>>) {
    let device = Default::default();
    let (x, [ih, hh, bias_ih, bias_hh]) = parts();
    let x = Tensor::<L, 3>::from_data(x, &device).require_grad();
    let weights = Weights {
        ih: Tensor::<L, 2>::from_data(ih, &device).require_grad(),
        hh: Tensor::<L, 2>::from_data(hh, &device).require_grad(),
        bias_ih: Tensor::<L, 1>::from_data(bias_ih, &device).require_grad(),
        bias_hh: Tensor::<L, 1>::from_data(bias_hh, &device).require_grad(),
    };
    let out = layer(x.clone(), weights.clone());
    let [steps, batch, _, units] = SIZE;
    let weighing = random(&mut RandomStream::new(12, "loss"), [steps, batch, units]);
    let loss = (out.clone() * Tensor::from_data(weighing, &device)).sum()
        + out.clone().powi_scalar(2).sum();
    let found = loss.backward();
    let vector = |t: TensorData| t.into_vec::<f32>().unwrap();
    let all = vec![
        vector(x.grad(&found).unwrap().into_data()),
        vector(weights.ih.grad(&found).unwrap().into_data()),
        vector(weights.hh.grad(&found).unwrap().into_data()),
        vector(weights.bias_ih.grad(&found).unwrap().into_data()),
        vector(weights.bias_hh.grad(&found).unwrap().into_data()),
    ];
    (vector(out.into_data()), all)
}

fn largest_difference(a: &[f32], b: &[f32]) -> f32 {
    assert_eq!(a.len(), b.len());
    a.iter()
        .zip(b)
        .map(|(a, b)| (a - b).abs())
        .fold(0.0, f32::max)
}

#[test]
fn forward_and_gradient_are_the_frameworks() {
    let (out, fast) = gradients(Fused::layer);
    let (expected, slow) = gradients::<Fused>(|x, weights| by_the_cell(x, &weights));
    assert!(largest_difference(&out, &expected) < 1e-6);
    for (fast, slow) in fast.iter().zip(&slow) {
        let size = slow.iter().fold(0.0f32, |m, v| m.max(v.abs()));
        assert!(size > 0.1 && largest_difference(fast, slow) < 2e-5 * size.max(1.0));
    }
}

/// The layer as a graphics card runs it, to a ten-thousandth: a card's tanh and exp are a few bits worse.
#[cfg(feature = "gpu")]
#[test]
fn a_graphics_card_computes_the_same_layer_and_gradient() {
    if !crate::device::tests::has_card() {
        return;
    }
    let (out, found) = gradients(Autodiff::<burn_wgpu::Wgpu>::layer);
    let (expected, fused) = gradients(Fused::layer);
    assert!(largest_difference(&out, &expected) < 1e-4);
    for (found, fused) in found.iter().zip(&fused) {
        let size = fused.iter().fold(0.0f32, |m, v| m.max(v.abs()));
        let difference = largest_difference(found, fused);
        println!("largest {size}, off by {difference:e}");
        assert!(size > 0.1 && difference < 1e-4 * size);
    }
}

/// The layer in f64, written from its equations and nothing else.
fn reference(x: &[f64], parts: &[Vec<f64>; 4]) -> Vec<f64> {
    let [steps, batch, inputs, units] = SIZE;
    let [ih, hh, bias_ih, bias_hh] = parts;
    let sigmoid = |v: f64| 1.0 / (1.0 + (-v).exp());
    let mut out = vec![0.0; steps * batch * units];
    for b in 0..batch {
        let mut h = vec![0.0; units];
        for t in 0..steps {
            let now = &x[(t * batch + b) * inputs..][..inputs];
            let dot = |m: &[f64], row: usize, v: &[f64]| -> f64 {
                m[row * v.len()..][..v.len()]
                    .iter()
                    .zip(v)
                    .map(|(m, v)| m * v)
                    .sum()
            };
            let a = |row: usize| dot(ih, row, now) + bias_ih[row];
            let c = |row: usize| dot(hh, row, &h) + bias_hh[row];
            let next: Vec<f64> = (0..units)
                .map(|i| {
                    let r = sigmoid(a(i) + c(i));
                    let z = sigmoid(a(units + i) + c(units + i));
                    let n = (a(2 * units + i) + r * c(2 * units + i)).tanh();
                    (1.0 - z) * n + z * h[i]
                })
                .collect();
            h = next;
            out[(t * batch + b) * units..][..units].copy_from_slice(&h);
        }
    }
    out
}

fn wide(t: TensorData) -> Vec<f64> {
    let values = t.into_vec::<f32>().unwrap();
    values.into_iter().map(f64::from).collect()
}

#[test]
fn forward_is_what_the_equations_say() {
    let (x, weights) = parts();
    let expected = reference(&wide(x), &weights.map(wide));
    let (out, _) = gradients(Fused::layer);
    let error = out
        .iter()
        .zip(&expected)
        .map(|(o, e)| (f64::from(*o) - e).abs())
        .fold(0.0, f64::max);
    assert!(error < 1e-6, "{error}");
}

#[test]
fn the_gradient_is_that_of_small_differences() {
    let (x, weights) = parts();
    let (x, weights) = (wide(x), weights.map(wide));
    let [steps, batch, _, units] = SIZE;
    let weighing = wide(random(
        &mut RandomStream::new(12, "loss"),
        [steps, batch, units],
    ));
    let loss = |x: &[f64], weights: &[Vec<f64>; 4]| -> f64 {
        let out = reference(x, weights);
        out.iter().zip(&weighing).map(|(o, w)| o * w + o * o).sum()
    };
    let (_, found) = gradients(Fused::layer);
    let step = 1e-5;
    for part in 0..5 {
        for index in (0..found[part].len()).step_by(7) {
            let at = |sign: f64| {
                let (mut x, mut weights) = (x.clone(), weights.clone());
                let place = if part == 0 {
                    &mut x[index]
                } else {
                    &mut weights[part - 1][index]
                };
                *place += sign * step;
                loss(&x, &weights)
            };
            let difference = (at(1.0) - at(-1.0)) / (2.0 * step);
            let error = (f64::from(found[part][index]) - difference).abs();
            assert!(
                error < 1e-4 * difference.abs().max(1.0),
                "part {part}, {index}: {error}"
            );
        }
    }
}
