//! The encoder: a checked model, and a whole window through it.

use alloc::vec::Vec;

use pulp::{Simd, WithSimd};

use super::kernel::{self, Rows};
use super::model::{LARGEST, Model, ModelError, SampleError};
use super::pack::{Aligned, Layer};
use crate::vector::Vectors;

/// A GRU encoder, ready to run. Immutable: what changes lies in a [`Room`] or a [`super::Stream`].
#[derive(Clone, Debug)]
pub struct Encoder {
    pub(super) vectors: Vectors,
    pub(super) layers: Vec<Layer>,
    /// The first layer's input weights once more, for [`kernel::project_wide`].
    pub(super) first: Vec<f64>,
    /// Smallest raw value and factor of every feature.
    scale: Vec<(f32, f32)>,
    window: usize,
}

impl Encoder {
    /// Checks the model and packs its weights.
    ///
    /// # Errors
    /// What of the model does not fit.
    pub fn new(model: &Model<'_>) -> Result<Self, ModelError> {
        Self::with(model, Vectors::widest())
    }

    /// Checks the model and packs its weights for these vectors, which change no bit of the results.
    ///
    /// # Errors
    /// What of the model does not fit.
    pub fn with(model: &Model<'_>, vectors: Vectors) -> Result<Self, ModelError> {
        model.check()?;
        let lanes = vectors.dispatch_widest(Lanes);
        let pack = |gru| Layer::new(gru, lanes);
        let scale = model.scale_min.iter().copied().zip(model.factors());
        let layers: Vec<Layer> = model.layers.iter().map(pack).collect();
        let first = layers.first().map_or(&[][..], |layer| layer.input.all());
        Ok(Self {
            vectors,
            first: first.iter().copied().map(f64::from).collect(),
            layers,
            scale: scale.collect(),
            window: model.window,
        })
    }

    /// Values of a sample.
    pub fn features(&self) -> usize {
        self.scale.len()
    }

    /// Values of a latent vector.
    pub fn latents(&self) -> usize {
        self.layers.last().map_or(0, |l| l.units)
    }

    /// Samples of a window.
    pub const fn window(&self) -> usize {
        self.window
    }

    /// Memory to encode a window in.
    pub fn room(&self) -> Room {
        let widest = self.layers.iter().map(Layer::width).max().unwrap_or(0);
        Room {
            scaled: alloc::vec![0.0; self.window * self.features()],
            sums: Aligned::zeros(self.window * 3 * widest),
            base: alloc::vec![0.0; self.first_stride()],
            states: Aligned::zeros(self.window * widest),
            zeros: Aligned::zeros(widest),
            latents: alloc::vec![0.0; self.latents()],
        }
    }

    /// The latent vector of a window, `[sample][feature]`, raw counts; every value in -1..1.
    ///
    /// # Errors
    /// Another length than a window's; a value that is not finite.
    pub fn encode<'r>(
        &self,
        room: &'r mut Room,
        samples: &[f32],
    ) -> Result<&'r [f32], SampleError> {
        let (features, expected) = (self.features(), room.scaled.len());
        if samples.len() != expected {
            let found = samples.len();
            return Err(SampleError::Length { expected, found });
        }
        for (i, sample) in samples.chunks_exact(features).enumerate() {
            let first = i * features;
            self.scale(sample, first, &mut room.scaled[first..][..features])?;
        }
        let encoder = self;
        self.vectors.dispatch_widest(Whole { encoder, room });
        Ok(&room.latents)
    }

    /// Scales one sample to its training range.
    ///
    /// # Errors
    /// A value that is not finite or far out; its index counts from `first`.
    pub(super) fn scale(
        &self,
        sample: &[f32],
        first: usize,
        out: &mut [f32],
    ) -> Result<(), SampleError> {
        for (feature, (&raw, &(low, factor))) in sample.iter().zip(&self.scale).enumerate() {
            let scaled = (raw - low) * factor;
            // The raw value apart: a factor of zero would hide an infinity.
            if !(raw.is_finite() && scaled.abs() <= LARGEST) {
                return Err(SampleError::Value {
                    index: first + feature,
                    feature,
                    found: raw,
                });
            }
            out[feature] = scaled;
        }
        Ok(())
    }

    /// Sums of a sample's projection by the first layer.
    pub(super) fn first_stride(&self) -> usize {
        3 * self.layers[0].width()
    }
}

/// Memory for a window, made once.
#[derive(Clone, Debug)]
pub struct Room {
    /// `[sample][feature]`.
    scaled: Vec<f32>,
    /// `[step][block][gate][lane]`.
    sums: Aligned,
    /// The first sample's projection.
    base: Vec<f64>,
    /// `[step][unit, padded]`.
    states: Aligned,
    zeros: Aligned,
    latents: Vec<f32>,
}

/// Out of a projection of a sample, one of the window's first sample and the bias: what the first layer's sums
/// start from. W (x - x0) = W x - W x0, so one projection of a sample serves every window that holds it.
#[inline(always)]
pub(super) fn offset(sample: &[f64], first: &[f64], bias: &[f32], out: &mut [f32]) {
    for (((out, s), f), b) in out.iter_mut().zip(sample).zip(first).zip(bias) {
        *out = ((s - f) + f64::from(*b)) as f32;
    }
}

/// The width of a vector.
struct Lanes;

impl WithSimd for Lanes {
    type Output = usize;
    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) -> usize {
        S::F32_LANES
    }
}

/// The scaled window in a room, to its latent vector.
struct Whole<'a> {
    encoder: &'a Encoder,
    room: &'a mut Room,
}

impl WithSimd for Whole<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self { encoder, room } = self;
        let first = &encoder.layers[0];
        let (stride, steps) = (encoder.first_stride(), encoder.window);
        let scaled = Rows {
            values: &room.scaled,
            stride: encoder.features(),
        };
        let (weights, base) = (&*encoder.first, &mut *room.base);
        kernel::project_wide(simd, first, weights, scaled, 1, |_, at, sums| {
            base[at..][..sums.len()].copy_from_slice(sums);
        });
        let (bias, out) = (first.bias.all(), room.sums.all_mut());
        kernel::project_wide(simd, first, weights, scaled, steps, |column, at, sums| {
            let out = &mut out[column * stride + at..][..sums.len()];
            offset(sums, &base[at..], &bias[at..], out);
        });
        let mut width = 0;
        for (l, layer) in encoder.layers.iter().enumerate() {
            if l > 0 {
                let inputs = Rows {
                    values: room.states.all(),
                    stride: width,
                };
                kernel::project(simd, layer, inputs, steps, room.sums.all_mut());
            }
            width = layer.width();
            for t in 0..steps {
                let sums = &room.sums.all()[t * 3 * width..][..3 * width];
                let (before, next) = room.states.all_mut().split_at_mut(t * width);
                let now = match t {
                    0 => room.zeros.all(),
                    _ => &before[(t - 1) * width..],
                };
                kernel::step_one(simd, layer, sums, now, next, t % 2 == 1);
            }
        }
        let last = &room.states.all()[(steps - 1) * width..];
        room.latents.copy_from_slice(&last[..encoder.latents()]);
    }
}
