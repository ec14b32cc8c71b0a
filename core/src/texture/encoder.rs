//! The encoder: a checked model, and whole windows through it.

use alloc::vec::Vec;

use pulp::{Simd, WithSimd};

use super::kernel::{self, Input, Rows};
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

    /// Memory to encode up to `windows` windows at once.
    pub fn room(&self, windows: usize) -> Room {
        let columns = windows * self.window;
        let widest = self.layers.iter().map(Layer::width).max().unwrap_or(0);
        Room {
            windows,
            scaled: alloc::vec![0.0; columns * self.features()],
            sums: Aligned::zeros(columns * 3 * widest),
            base: alloc::vec![0.0; windows * self.first_stride()],
            states: Aligned::zeros(columns * widest),
            zeros: Aligned::zeros(windows * widest),
            latents: alloc::vec![0.0; windows * self.latents()],
        }
    }

    /// Latent vectors of as many windows as `samples` holds, `[window][sample][feature]`, raw counts; returns
    /// `[window][latent]`, every value in -1..1.
    ///
    /// # Errors
    /// A length that is no whole number of windows or more than the room holds; a value that is not finite.
    pub fn encode<'r>(
        &self,
        room: &'r mut Room,
        samples: &[f32],
    ) -> Result<&'r [f32], SampleError> {
        let (features, per_window) = (self.features(), self.window * self.features());
        let windows = (samples.len() / per_window).clamp(1, room.windows);
        if samples.len() != windows * per_window {
            return Err(SampleError::Length {
                expected: windows * per_window,
                found: samples.len(),
            });
        }
        for (i, sample) in samples.chunks_exact(features).enumerate() {
            let (window, at) = (i / self.window, i % self.window);
            let column = at * windows + window;
            let out = &mut room.scaled[column * features..][..features];
            self.scale(sample, i * features, out)?;
        }
        self.vectors.dispatch_widest(Whole {
            encoder: self,
            room,
            windows,
        });
        Ok(&room.latents[..windows * self.latents()])
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

/// Memory for whole windows, made once.
#[derive(Clone, Debug)]
pub struct Room {
    pub(super) windows: usize,
    /// `[sample][window][feature]`.
    scaled: Vec<f32>,
    /// `[step][window][block][gate][lane]`.
    pub(super) sums: Aligned,
    /// The first samples' projections.
    base: Vec<f64>,
    /// `[step][window][unit, padded]`.
    states: Aligned,
    zeros: Aligned,
    /// `[window][latent]`.
    pub(super) latents: Vec<f32>,
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

/// Scaled windows in a room, to latents.
struct Whole<'a> {
    encoder: &'a Encoder,
    room: &'a mut Room,
    windows: usize,
}

impl WithSimd for Whole<'_> {
    type Output = ();
    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self {
            encoder,
            room,
            windows,
        } = self;
        let first = &encoder.layers[0];
        let (stride, features) = (encoder.first_stride(), encoder.features());
        let scaled = Rows {
            values: &room.scaled,
            stride: features,
        };
        let (weights, base) = (&*encoder.first, &mut *room.base);
        kernel::project_wide(simd, first, weights, scaled, windows, |column, at, sums| {
            base[column * stride + at..][..sums.len()].copy_from_slice(sums);
        });
        let columns = encoder.window * windows;
        let (bias, out) = (first.bias.all(), room.sums.all_mut());
        kernel::project_wide(simd, first, weights, scaled, columns, |column, at, sums| {
            let base = &base[(column % windows) * stride + at..];
            let out = &mut out[column * stride + at..][..sums.len()];
            offset(sums, base, &bias[at..], out);
        });
        layers(simd, encoder, room, windows);
    }
}

/// From the first layer's sums in `room` `[step][window]` through all layers, to `room.latents`.
#[inline(always)]
pub(super) fn layers<S: Simd>(simd: S, encoder: &Encoder, room: &mut Room, windows: usize) {
    let steps = encoder.window;
    let mut width = 0;
    for (l, layer) in encoder.layers.iter().enumerate() {
        if l > 0 {
            let inputs = Rows {
                values: room.states.all(),
                stride: width,
            };
            let columns = steps * windows;
            kernel::project(simd, layer, inputs, columns, room.sums.all_mut());
        }
        width = layer.width();
        let (row, sums_of) = (windows * width, windows * 3 * width);
        for t in 0..steps {
            let sums = &room.sums.all()[t * sums_of..][..sums_of];
            let (before, next) = room.states.all_mut().split_at_mut(t * row);
            let now = if t == 0 {
                room.zeros.all()
            } else {
                &before[(t - 1) * row..]
            };
            if windows == 1 {
                kernel::step_one(simd, layer, sums, now, next, t % 2 == 1);
            } else {
                let sums = Input::Summed(Rows {
                    values: sums,
                    stride: 3 * width,
                });
                kernel::step(simd, layer, sums, now, next, windows);
            }
        }
    }
    let latents = encoder.latents();
    let last = &room.states.all()[(steps - 1) * windows * width..];
    for (state, out) in last
        .chunks_exact(width)
        .zip(room.latents.chunks_exact_mut(latents))
        .take(windows)
    {
        out.copy_from_slice(&state[..latents]);
    }
}
