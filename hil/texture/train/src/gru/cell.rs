//! The layer written with the framework's own operations: one product for the three gates of a step.
//!
//! Graphics cards run it, and tests compare [`super::fused`] with it: its gradient is the framework's.

use burn::prelude::*;
use burn::tensor::activation::sigmoid;

#[cfg(feature = "gpu")]
use super::Recurrent;
use super::Weights;

#[cfg(feature = "gpu")]
impl Recurrent for burn_wgpu::Wgpu {
    fn layer(x: Tensor<Self, 3>, weights: Weights<Self>) -> Tensor<Self, 3> {
        sequence(x, &weights)
    }
}

#[cfg(feature = "gpu")]
impl Recurrent for burn::backend::Autodiff<burn_wgpu::Wgpu> {
    fn layer(x: Tensor<Self, 3>, weights: Weights<Self>) -> Tensor<Self, 3> {
        sequence(x, &weights)
    }
}

/// All hidden states [steps, batch, H] of `x` [steps, batch, I], from a hidden state of zero.
pub fn sequence<B: Backend>(x: Tensor<B, 3>, weights: &Weights<B>) -> Tensor<B, 3> {
    let [steps, batch, inputs] = x.dims();
    let [gates, units] = weights.hh.dims();
    let device = x.device();
    let bias_ih = weights.bias_ih.clone().unsqueeze::<2>();
    let bias_hh = weights.bias_hh.clone().unsqueeze::<2>();
    let rows = x.reshape([steps * batch, inputs]);
    let inputs = rows.matmul(weights.ih.clone().transpose()) + bias_ih;
    let inputs = inputs.reshape([steps, batch, gates]);
    let recurrent = weights.hh.clone().transpose();
    let mut hidden = Tensor::<B, 2>::zeros([batch, units], &device);
    let mut all = Vec::with_capacity(steps);
    for step in 0..steps {
        let from_input = inputs.clone().narrow(0, step, 1).reshape([batch, gates]);
        let from_hidden = hidden.clone().matmul(recurrent.clone()) + bias_hh.clone();
        let part = |t: &Tensor<B, 2>, gate: usize| {
            t.clone()
                .slice([0..batch, gate * units..(gate + 1) * units])
        };
        let r = sigmoid(part(&from_input, 0) + part(&from_hidden, 0));
        let z = sigmoid(part(&from_input, 1) + part(&from_hidden, 1));
        let n = (part(&from_input, 2) + r * part(&from_hidden, 2)).tanh();
        hidden = n.clone() + z * (hidden - n);
        all.push(hidden.clone().unsqueeze_dim::<3>(0));
    }
    Tensor::cat(all, 0)
}
