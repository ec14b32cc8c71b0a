//! The first two layers answer a ripple and not a slope.

use burn::prelude::*;

use crate::network::{Network, WIDTH};
use crate::training::Plain;

/// Root mean square of the fast units of the first layer after some steps, and mean size unit of the second.
fn heard(input: impl Fn(usize) -> f32) -> [f64; 2] {
    let mut network = Network::<Plain>::new(4, 3, 60, 1, &Default::default());
    network.hear_what_is_fast(1);
    let values: Vec<f32> = (0..60).flat_map(|t| [input(t), 0.0, 0.0, 0.0]).collect();
    let x = Tensor::from_data(TensorData::new(values, [60, 1, 4]), &Default::default());
    let [first, second] = network.first_layers(x);
    let late = |values: Vec<f32>, from: usize, to: usize| -> Vec<f64> {
        let rows = values.chunks_exact(WIDTH).skip(20);
        rows.flat_map(|row| row[from..to].to_vec())
            .map(f64::from)
            .collect()
    };
    let fast = late(first, 4, 8);
    let sizes = late(second, 0, super::MIXTURES);
    let count = |of: &[f64]| of.len() as f64;
    [
        (fast.iter().map(|v| v * v).sum::<f64>() / count(&fast)).sqrt(),
        sizes.iter().map(|v| v.abs()).sum::<f64>() / count(&sizes),
    ]
}

#[test]
fn a_ripple_is_heard_and_a_load_is_not() {
    let ripple = |t: usize| if t.is_multiple_of(2) { 0.3 } else { -0.3 };
    let [fast, size] = heard(ripple);
    let [fast_load, size_load] = heard(|_| 0.3);
    assert!(fast > 10.0 * fast_load, "{fast} {fast_load}");
    assert!(size > 2.0 * size_load, "{size} {size_load}");
    // a load beside the ripple changes little
    let [both, _] = heard(|t| ripple(t) + 1.0);
    assert!((both / fast - 1.0).abs() < 0.2, "{both} {fast}");
}
