//! A GRU layer over a whole sequence: forward, backward, and the plain cell both are held against.
//!
//! The cell is the one with two biases (`reset_after` in Keras, PyTorch's own; ONNX `linear_before_reset = 1`):
//! `r, z = s(W x + b + U h + c)`, `n = tanh(W x + b + r (U h + c))`, `h' = (1 - z) n + z h`, gates in the order r, z, n.
//! Sequences are time-major, `[steps, batch, features]`, so that a step is one piece of memory.

#[cfg(any(test, feature = "gpu"))]
mod cell;
mod fused;
mod op;
mod panels;

#[cfg(test)]
pub use cell::sequence as by_the_cell;
pub use op::{Learning, Recurrent};

use burn::prelude::*;

/// A layer's tensors: `ih` [3H, I], `hh` [3H, H], both biases [3H].
#[derive(Clone, Debug)]
pub struct Weights<B: Backend> {
    pub ih: Tensor<B, 2>,
    pub hh: Tensor<B, 2>,
    pub bias_ih: Tensor<B, 1>,
    pub bias_hh: Tensor<B, 1>,
}

/// Sizes of a layer's work.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Size {
    pub steps: usize,
    pub batch: usize,
    pub inputs: usize,
    pub units: usize,
}

#[cfg(test)]
mod tests;
