//! The layer as an operation of the framework, with the forward and backward passes that autodiff calls.

use std::sync::Arc;

use burn::backend::autodiff::checkpoint::base::Checkpointer;
use burn::backend::autodiff::checkpoint::strategy::NoCheckpointing;
use burn::backend::autodiff::grads::Gradients;
use burn::backend::autodiff::ops::{Backward, Ops, OpsKind};
use burn::backend::ndarray::NdArrayTensor;
use burn::backend::{Autodiff, NdArray};
use burn::prelude::*;
use burn::tensor::TensorPrimitive;
use burn::tensor::backend::AutodiffBackend;

use super::fused::{self, Flat, Trace};
use super::{Size, Weights};

/// A backend that can run a layer.
pub trait Recurrent: Backend {
    /// All hidden states [steps, batch, H] of `x` [steps, batch, I], from a hidden state of zero.
    fn layer(x: Tensor<Self, 3>, weights: Weights<Self>) -> Tensor<Self, 3>;
}

/// A backend that learns: the layer with its gradient on it, the layer alone beneath it.
pub trait Learning: Recurrent + AutodiffBackend<InnerBackend: Recurrent> {}

impl<B: Recurrent + AutodiffBackend<InnerBackend: Recurrent>> Learning for B {}

type Inner = NdArray;
type Primitive = <Inner as burn::tensor::backend::BackendTypes>::FloatTensorPrimitive;

/// Row by row. (The framework's own `into_data` copies a tensor that others hold too number by number.)
fn values<const D: usize>(tensor: Tensor<Inner, D>) -> Vec<f32> {
    let NdArrayTensor::F32(numbers) = tensor.into_primitive().tensor() else {
        unreachable!("training is in f32")
    };
    let rows = numbers.view().as_standard_layout().into_owned();
    rows.into_raw_vec_and_offset().0
}

fn primitive<const D: usize>(values: Vec<f32>, shape: [usize; D]) -> Primitive {
    let data = TensorData::new(values, shape);
    Tensor::<Inner, D>::from_data(data, &Default::default())
        .into_primitive()
        .tensor()
}

fn flat(weights: Weights<Inner>) -> Flat {
    Flat {
        ih: values(weights.ih),
        hh: values(weights.hh),
        bias_ih: values(weights.bias_ih),
        bias_hh: values(weights.bias_hh),
    }
}

fn size<B: Backend>(x: &Tensor<B, 3>, weights: &Weights<B>) -> Size {
    let [steps, batch, inputs] = x.dims();
    let [_, units] = weights.hh.dims();
    Size {
        steps,
        batch,
        inputs,
        units,
    }
}

impl Recurrent for Inner {
    fn layer(x: Tensor<Self, 3>, weights: Weights<Self>) -> Tensor<Self, 3> {
        let size = size(&x, &weights);
        let trace = fused::forward(&values(x), &flat(weights), size);
        Tensor::from_data(
            TensorData::new(trace.hidden, [size.steps, size.batch, size.units]),
            &Default::default(),
        )
    }
}

#[derive(Clone, Debug)]
struct Saved {
    x: Arc<Vec<f32>>,
    weights: Arc<Flat>,
    trace: Arc<Trace>,
    size: Size,
}

#[derive(Debug)]
struct LayerBackward;

impl Backward<Inner, 5> for LayerBackward {
    type State = Saved;

    fn backward(self, ops: Ops<Saved, 5>, grads: &mut Gradients, _: &mut Checkpointer) {
        let Saved {
            x,
            weights,
            trace,
            size,
        } = ops.state;
        let above = TensorPrimitive::Float(grads.consume::<Inner>(&ops.node));
        let above = values(Tensor::<Inner, 3>::from_primitive(above));
        let [to_x, ih, hh, bias_ih, bias_hh] = ops.parents;
        let found = fused::backward(&x, &weights, &trace, &above, size, to_x.is_some());
        let Size {
            steps,
            batch,
            inputs,
            units,
        } = size;
        if let (Some(node), Some(input)) = (to_x, found.input) {
            grads.register::<Inner>(node.id, primitive(input, [steps, batch, inputs]));
        }
        let found = found.weights;
        let tensors = [
            (ih, primitive(found.ih, [3 * units, inputs])),
            (hh, primitive(found.hh, [3 * units, units])),
            (bias_ih, primitive(found.bias_ih, [3 * units])),
            (bias_hh, primitive(found.bias_hh, [3 * units])),
        ];
        for (node, gradient) in tensors {
            if let Some(node) = node {
                grads.register::<Inner>(node.id, gradient);
            }
        }
    }
}

impl Recurrent for Autodiff<Inner> {
    fn layer(x: Tensor<Self, 3>, weights: Weights<Self>) -> Tensor<Self, 3> {
        let size = size(&x, &weights);
        let inner = flat(Weights {
            ih: weights.ih.clone().inner(),
            hh: weights.hh.clone().inner(),
            bias_ih: weights.bias_ih.clone().inner(),
            bias_hh: weights.bias_hh.clone().inner(),
        });
        let input = values(x.clone().inner());
        let trace = fused::forward(&input, &inner, size);
        let output = primitive(trace.hidden.clone(), [size.steps, size.batch, size.units]);
        let nodes = [
            x.into_primitive().tensor().node,
            weights.ih.into_primitive().tensor().node,
            weights.hh.into_primitive().tensor().node,
            weights.bias_ih.into_primitive().tensor().node,
            weights.bias_hh.into_primitive().tensor().node,
        ];
        let output = match LayerBackward
            .prepare::<NoCheckpointing>(nodes)
            .compute_bound()
            .stateful()
        {
            OpsKind::Tracked(prep) => {
                let state = Saved {
                    x: Arc::new(input),
                    weights: Arc::new(inner),
                    trace: Arc::new(trace),
                    size,
                };
                prep.finish(state, output)
            }
            OpsKind::UnTracked(prep) => prep.finish(output),
        };
        Tensor::from_primitive(TensorPrimitive::Float(output))
    }
}
