//! The encoder as its equations stand, in f64: what tests and benchmarks hold the engine against.

use palpate_core::texture::{Gru, Model};

/// z of one window `[sample][feature]` of raw counts. The model's shapes fit (an `Encoder` was made of it).
pub fn encode(model: &Model<'_>, window: &[f32]) -> Vec<f64> {
    let features = model.scale_min.len();
    let range = |i: usize| f64::from(model.scale_max[i]) - f64::from(model.scale_min[i]);
    let scaled = |value: f32, i: usize| match range(i) {
        // A feature that was constant in training carries nothing.
        0.0 => 0.0,
        range => (f64::from(value) - f64::from(model.scale_min[i])) / range,
    };
    let of = |sample: &[f32]| -> Vec<f64> {
        let change = |(i, (&now, &first))| scaled(now, i) - scaled(first, i);
        sample.iter().zip(window).enumerate().map(change).collect()
    };
    let mut sequence: Vec<_> = window.chunks_exact(features).map(of).collect();
    for layer in model.layers {
        let mut state = vec![0.0; layer.units];
        for values in &mut sequence {
            state = step(layer, values, &state);
            values.clone_from(&state);
        }
    }
    sequence.pop().unwrap_or_default()
}

/// One step: r = s(W_r x + b_r + U_r h + c_r), z alike, n = tanh(W_n x + b_n + r (U_n h + c_n)),
/// h' = (1 - z) n + z h.
fn step(layer: &Gru<'_>, x: &[f64], h: &[f64]) -> Vec<f64> {
    let sum = |weights: &[f32], bias: &[f32], row: usize, values: &[f64]| {
        let weights = &weights[row * values.len()..][..values.len()];
        let products = weights.iter().zip(values).map(|(w, v)| f64::from(*w) * v);
        f64::from(bias[row]) + products.sum::<f64>()
    };
    let logistic = |v: f64| 1.0 / (1.0 + libm::exp(-v));
    let unit = |unit: usize| {
        let gate = |g: usize| {
            let row = g * layer.units + unit;
            let from_x = sum(layer.weight_ih, layer.bias_ih, row, x);
            (from_x, sum(layer.weight_hh, layer.bias_hh, row, h))
        };
        let ((rx, rh), (zx, zh), (nx, nh)) = (gate(0), gate(1), gate(2));
        let (r, z) = (logistic(rx + rh), logistic(zx + zh));
        let n = libm::tanh(nx + r * nh);
        (1.0 - z) * n + z * h[unit]
    };
    (0..layer.units).map(unit).collect()
}
