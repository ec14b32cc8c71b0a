//! An approximation: one state that is never begun anew, one step a sample.
//!
//! A hundred times less work than exact windows a sample apart, and another function: the network was trained on
//! windows that begin with a state of zero. Samples are taken less a reference that stays until
//! [`Stateful::restart`]. How far it is off is measured in `hil bench texture`.

use alloc::sync::Arc;
use alloc::vec::Vec;

use pulp::{Simd, WithSimd};

use super::encoder::{Encoder, offset};
use super::kernel::{self, Input, Rows};
use super::model::SampleError;
use super::pack::{Aligned, Layer};

/// A running state of one module.
#[derive(Clone, Debug)]
pub struct Stateful {
    encoder: Arc<Encoder>,
    fresh: bool,
    scaled: Vec<f32>,
    sample: Vec<f64>,
    reference: Vec<f64>,
    sums: Aligned,
    now: Vec<Aligned>,
    next: Vec<Aligned>,
}

impl Stateful {
    /// A state of zero; the first sample becomes the reference.
    pub fn new(encoder: Arc<Encoder>) -> Self {
        let stride = encoder.first_stride();
        let state = |layer: &Layer| Aligned::zeros(layer.width());
        Self {
            fresh: true,
            scaled: alloc::vec![0.0; encoder.features()],
            sample: alloc::vec![0.0; stride],
            reference: alloc::vec![0.0; stride],
            sums: Aligned::zeros(stride),
            now: encoder.layers.iter().map(state).collect(),
            next: encoder.layers.iter().map(state).collect(),
            encoder,
        }
    }

    /// Back to a state of zero; the next sample becomes the reference.
    pub fn restart(&mut self) {
        self.fresh = true;
        for states in &mut self.now {
            states.all_mut().fill(0.0);
        }
    }

    /// Takes a sample of raw counts and returns the last layer's state.
    ///
    /// # Errors
    /// A wrong length or a value that is not finite; nothing has changed.
    pub fn push(&mut self, sample: &[f32]) -> Result<&[f32], SampleError> {
        if sample.len() != self.scaled.len() {
            return Err(SampleError::Length {
                expected: self.scaled.len(),
                found: sample.len(),
            });
        }
        self.encoder.scale(sample, 0, &mut self.scaled)?;
        let encoder = Arc::clone(&self.encoder);
        encoder.vectors.dispatch_widest(Step(self));
        core::mem::swap(&mut self.now, &mut self.next);
        let latents = encoder.latents();
        Ok(self.now.last().map_or(&[], |s| &s.all()[..latents]))
    }
}

struct Step<'a>(&'a mut Stateful);

impl WithSimd for Step<'_> {
    type Output = ();
    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let state = self.0;
        let layers = &state.encoder.layers;
        let inputs = Rows {
            values: &state.scaled,
            stride: state.scaled.len(),
        };
        let (weights, sample) = (&*state.encoder.first, &mut *state.sample);
        kernel::project_wide(simd, &layers[0], weights, inputs, 1, |_, at, sums| {
            sample[at..][..sums.len()].copy_from_slice(sums);
        });
        if state.fresh {
            state.reference.copy_from_slice(&state.sample);
            state.fresh = false;
        }
        let bias = layers[0].bias.all();
        offset(&state.sample, &state.reference, bias, state.sums.all_mut());
        let mut input = Input::Summed(Rows {
            values: state.sums.all(),
            stride: state.sums.all().len(),
        });
        for (layer, (now, next)) in layers.iter().zip(state.now.iter().zip(&mut state.next)) {
            kernel::step(simd, layer, input, now.all(), next.all_mut(), 1);
            input = Input::Raw(Rows {
                values: next.all(),
                stride: layer.width(),
            });
        }
    }
}
