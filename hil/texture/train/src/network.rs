//! The network of Table 3.1 for any number of features: four GRU layers down to the latent vector, four up again.

use burn::module::Param;
use burn::prelude::*;
use palpate_core::random::RandomStream;

use crate::gru::{Recurrent, Weights};
use crate::start::{Layer, high_pass, sizes};

/// Units of the wide layers.
pub const WIDTH: usize = 96;

/// One GRU layer.
#[derive(Module, Debug)]
pub struct Gru<B: Backend> {
    pub weight_ih: Param<Tensor<B, 2>>,
    pub weight_hh: Param<Tensor<B, 2>>,
    pub bias_ih: Param<Tensor<B, 1>>,
    pub bias_hh: Param<Tensor<B, 1>>,
}

/// The autoencoder.
#[derive(Module, Debug)]
pub struct Network<B: Backend> {
    pub encoder: Vec<Gru<B>>,
    pub decoder: Vec<Gru<B>>,
    pub dense_weight: Param<Tensor<B, 2>>,
    pub dense_bias: Param<Tensor<B, 1>>,
}

/// Draws a parameter value by value.
fn drawn<B: Backend, const D: usize>(
    shape: [usize; D],
    draw: impl FnMut(usize) -> f64,
    device: &B::Device,
) -> Param<Tensor<B, D>> {
    let values: Vec<f32> = (0..shape.iter().product())
        .map(draw)
        .map(|v| v as f32)
        .collect();
    Param::from_data(TensorData::new(values, shape), device)
}

/// Uniform draws by the sum of both widths (Glorot & Bengio 2010): the start of Keras, and with it of the thesis.
fn glorot<B: Backend>(
    stream: &mut RandomStream,
    out: usize,
    inputs: usize,
    per: usize,
    device: &B::Device,
) -> Param<Tensor<B, 2>> {
    let bound = (6.0 / (per + inputs) as f64).sqrt();
    drawn(
        [out, inputs],
        |_| bound * (2.0 * stream.uniform() - 1.0),
        device,
    )
}

/// An orthogonal matrix, row-major.
fn orthogonal(stream: &mut RandomStream, width: usize) -> Vec<f64> {
    let mut rows: Vec<Vec<f64>> = Vec::with_capacity(width);
    while rows.len() < width {
        let mut row: Vec<f64> = (0..width).map(|_| stream.normal()).collect();
        let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        for _twice in 0..2 {
            for earlier in &rows {
                let share = dot(&row, earlier);
                row.iter_mut()
                    .zip(earlier)
                    .for_each(|(r, e)| *r -= share * e);
            }
        }
        let length = dot(&row, &row).sqrt();
        if length > 1e-3 {
            rows.push(row.iter().map(|r| r / length).collect());
        }
    }
    rows.concat()
}

impl<B: Backend> Gru<B> {
    /// Orthogonal in time. The update gates begin with memories of 1 to `steps` steps (Tallec & Ollivier 2018):
    /// without that a window's beginning is forgotten long before its end.
    fn new(
        stream: &mut RandomStream,
        [inputs, units]: [usize; 2],
        steps: usize,
        device: &B::Device,
    ) -> Self {
        let recurrent: Vec<f64> = (0..3).flat_map(|_| orthogonal(stream, units)).collect();
        let memory = |stream: &mut RandomStream| {
            (1.0 + stream.uniform() * steps.saturating_sub(2) as f64).ln()
        };
        Self {
            weight_ih: glorot(stream, 3 * units, inputs, units, device),
            weight_hh: drawn([3 * units, units], |i| recurrent[i], device),
            bias_ih: drawn(
                [3 * units],
                |i| if i / units == 1 { memory(stream) } else { 0.0 },
                device,
            ),
            bias_hh: drawn([3 * units], |_| 0.0, device),
        }
    }
}

impl<B: Backend> Network<B> {
    /// Weights drawn with a seed, the same on every backend, for windows of `steps`.
    pub fn new(
        features: usize,
        latent: usize,
        steps: usize,
        seed: u64,
        device: &B::Device,
    ) -> Self {
        let mut stream = RandomStream::new(seed, "initial weights");
        let stack = |stream: &mut RandomStream, widths: [usize; 5]| {
            widths
                .windows(2)
                .map(|w| Gru::new(stream, [w[0], w[1]], steps, device))
                .collect()
        };
        Self {
            encoder: stack(&mut stream, [features, WIDTH, WIDTH, WIDTH, latent]),
            decoder: stack(&mut stream, [latent, latent, WIDTH, WIDTH, WIDTH]),
            dense_weight: glorot(&mut stream, features, WIDTH, features, device),
            dense_bias: drawn([features], |_| 0.0, device),
        }
    }
}

impl<B: Backend> Network<B> {
    /// Gives the first two layers the start of [`crate::start`].
    pub fn hear_what_is_fast(&mut self, seed: u64) {
        let mut stream = RandomStream::new(seed, "weights that hear what is fast");
        let features = self.dense_bias.val().dims()[0];
        self.encoder[0].change(high_pass);
        self.encoder[1].change(|layer| sizes(layer, features, &mut stream));
    }
}

impl<B: Backend> Gru<B> {
    fn change(&mut self, change: impl FnOnce(Layer<'_>)) {
        let device = self.bias_ih.val().device();
        let [rows, inputs] = self.weight_ih.val().dims();
        let units = rows / 3;
        let values = |data: TensorData| -> Vec<f64> { data.iter::<f32>().map(f64::from).collect() };
        let mut ih = values(self.weight_ih.val().into_data());
        let mut hh = values(self.weight_hh.val().into_data());
        let mut bias_ih = values(self.bias_ih.val().into_data());
        change(Layer {
            ih: &mut ih,
            hh: &mut hh,
            bias_ih: &mut bias_ih,
            inputs,
            units,
        });
        self.weight_ih = drawn([rows, inputs], |i| ih[i], &device);
        self.weight_hh = drawn([rows, units], |i| hh[i], &device);
        self.bias_ih = drawn([rows], |i| bias_ih[i], &device);
    }
}

/// A tensor's name, shape and numbers, row by row.
pub type Named = (String, Vec<usize>, Vec<f32>);

fn named<B: Backend, const D: usize>(name: String, param: &Param<Tensor<B, D>>) -> Named {
    let tensor = param.val();
    let shape = tensor.dims().to_vec();
    let values = tensor.into_data().into_vec();
    (name, shape, values.expect("training is in f32"))
}

impl<B: Backend> Network<B> {
    /// Every tensor, by PyTorch's names; without the decoder's where it has learned nothing.
    pub fn tensors(&self, decodes: bool) -> Vec<Named> {
        let mut all = Vec::new();
        let decoder: &[_] = if decodes { &self.decoder } else { &[] };
        for (stack, layers) in [("encoder", &self.encoder[..]), ("decoder", decoder)] {
            for (number, layer) in layers.iter().enumerate() {
                let name = |part: &str| format!("{stack}.{number}.{part}");
                all.push(named(name("weight_ih"), &layer.weight_ih));
                all.push(named(name("weight_hh"), &layer.weight_hh));
                all.push(named(name("bias_ih"), &layer.bias_ih));
                all.push(named(name("bias_hh"), &layer.bias_hh));
            }
        }
        if decodes {
            all.push(named("dense.weight".into(), &self.dense_weight));
            all.push(named("dense.bias".into(), &self.dense_bias));
        }
        all
    }
}

impl<B: Recurrent> Gru<B> {
    fn forward(&self, x: Tensor<B, 3>) -> Tensor<B, 3> {
        let weights = Weights {
            ih: self.weight_ih.val(),
            hh: self.weight_hh.val(),
            bias_ih: self.bias_ih.val(),
            bias_hh: self.bias_hh.val(),
        };
        B::layer(x, weights)
    }
}

impl<B: Recurrent> Network<B> {
    /// Latent vectors [batch, latent] of windows [steps, batch, features].
    pub fn encode(&self, windows: Tensor<B, 3>) -> Tensor<B, 2> {
        last(self.states(windows))
    }

    /// Latent vectors [steps, batch, latent] that windows would have if they ended with each step.
    pub fn states(&self, windows: Tensor<B, 3>) -> Tensor<B, 3> {
        let layers = self.encoder.iter();
        layers.fold(windows, |x, layer| layer.forward(x))
    }

    /// States of the first two layers, step by step.
    #[cfg(test)]
    pub fn first_layers(&self, x: Tensor<B, 3>) -> [Vec<f32>; 2] {
        let first = self.encoder[0].forward(x);
        let second = self.encoder[1].forward(first.clone());
        [first, second].map(|x| x.into_data().into_vec().expect("training is in f32"))
    }

    /// Windows [steps, batch, features] of latent vectors [batch, latent].
    pub fn decode(&self, latent: Tensor<B, 2>, steps: usize) -> Tensor<B, 3> {
        let [batch, width] = latent.dims();
        let mut x = latent.unsqueeze_dim::<3>(0).expand([steps, batch, width]);
        for layer in &self.decoder {
            x = layer.forward(x);
        }
        let weight = self.dense_weight.val();
        let [features, width] = weight.dims();
        let rows = x.reshape([steps * batch, width]);
        let out = rows.matmul(weight.transpose()) + self.dense_bias.val().unsqueeze::<2>();
        out.reshape([steps, batch, features])
    }
}

/// The states of the last step.
pub fn last<B: Backend>(states: Tensor<B, 3>) -> Tensor<B, 2> {
    let [steps, batch, width] = states.dims();
    states.narrow(0, steps - 1, 1).reshape([batch, width])
}

#[cfg(test)]
#[path = "network_tests.rs"]
mod tests;
