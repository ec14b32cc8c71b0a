//! Windows one sample apart: every window in flight is a column, one step a sample.
//!
//! The first layer's projection of a sample is made once and kept for as long as a window that began with it is in
//! flight. Only windows that a caller wants are computed; what is computed does not depend on what is left out.

use alloc::sync::Arc;
use alloc::vec::Vec;

use pulp::{Simd, WithSimd};

use super::encoder::{Encoder, offset};
use super::kernel::{self, Input, Rows};
use super::model::SampleError;
use super::pack::{Aligned, Layer};
use crate::units::Duration;

/// Windows that are asked for, by the samples that they end with.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Ends {
    /// Every one.
    Every,
    /// The newest at each onset of a grid from t = 0; sample n is taken at n times `sample`.
    Onsets {
        /// Time from sample to sample.
        sample: Duration,
        /// Time from onset to onset (the SOA).
        every: Duration,
    },
}

impl Ends {
    /// Tells whether the window that ends with sample `n` is asked for.
    pub const fn asked(self, n: u64) -> bool {
        match self {
            Self::Every => true,
            Self::Onsets { sample, every } => {
                let (sample, every) = (sample.as_micros(), every.as_micros());
                if every <= sample {
                    return true; // at least one onset a sample
                }
                let next = n.saturating_mul(sample).div_ceil(every);
                next.saturating_mul(every) < n.saturating_add(1).saturating_mul(sample)
            }
        }
    }

    /// Tells whether a window of `window` samples that begins with sample `n` is asked for.
    pub const fn begins(self, n: u64, window: usize) -> bool {
        self.asked(n.saturating_add(window as u64 - 1))
    }
}

/// Columns that go through all layers together: their states stay in the nearest caches.
const GROUP: usize = 51;

/// Windows in flight of one or more modules that are sampled together.
#[derive(Clone, Debug)]
pub struct Stream {
    encoder: Arc<Encoder>,
    modules: usize,
    seen: u64,
    /// `[module][feature]`.
    scaled: Vec<f32>,
    /// The last samples' projections by the first layer, `[sample, a ring][module][block][gate][lane]`.
    ring: Vec<f64>,
    /// The windows that are being stepped: the place in the ring of the sample they began with.
    slots: Vec<usize>,
    /// A layer's states, `[slot][module][unit, padded]`, before and after this sample.
    now: Vec<Aligned>,
    next: Vec<Aligned>,
    sums: Aligned,
    latents: Vec<f32>,
}

impl Stream {
    /// A stream for `modules` modules; nothing is in flight.
    pub fn new(encoder: Arc<Encoder>, modules: usize) -> Self {
        let (window, stride) = (encoder.window(), encoder.first_stride());
        let state = |layer: &Layer| Aligned::zeros(window * modules * layer.width());
        Self {
            modules,
            seen: 0,
            scaled: alloc::vec![0.0; modules * encoder.features()],
            ring: alloc::vec![0.0; window * modules * stride],
            slots: Vec::with_capacity(window),
            now: encoder.layers.iter().map(state).collect(),
            next: encoder.layers.iter().map(state).collect(),
            sums: Aligned::zeros(GROUP * stride),
            latents: alloc::vec![0.0; modules * encoder.latents()],
            encoder,
        }
    }

    /// Samples taken since the start.
    pub const fn seen(&self) -> u64 {
        self.seen
    }

    /// Windows that are open: each takes a step of every sample.
    pub const fn in_flight(&self) -> usize {
        self.slots.len()
    }

    /// Takes a sample of every module, `[module][feature]`, raw counts. With `begin` a window starts with it. Returns
    /// the latent vectors `[module][latent]` of the window that ended with it, if one did.
    ///
    /// # Errors
    /// A wrong length or a value that is not finite; the stream is as before, the sample not taken.
    pub fn push(&mut self, sample: &[f32], begin: bool) -> Result<Option<&[f32]>, SampleError> {
        let features = self.encoder.features();
        if sample.len() != self.scaled.len() {
            return Err(SampleError::Length {
                expected: self.scaled.len(),
                found: sample.len(),
            });
        }
        for (m, sample) in sample.chunks_exact(features).enumerate() {
            let out = &mut self.scaled[m * features..][..features];
            self.encoder.scale(sample, m * features, out)?;
        }
        let window = self.encoder.window();
        let at = (self.seen % window as u64) as usize;
        if begin {
            self.open(at);
        }
        let encoder = Arc::clone(&self.encoder);
        encoder.vectors.dispatch_widest(Hop { stream: self, at });
        core::mem::swap(&mut self.now, &mut self.next);
        self.seen += 1;
        let ends = (at + 1) % window;
        let ended = self.slots.iter().position(|&start| start == ends);
        Ok(ended
            .filter(|_| self.seen >= window as u64)
            .map(|slot| self.close(slot)))
    }

    /// A slot of zero states.
    fn open(&mut self, start: usize) {
        let slot = self.slots.len();
        for (layer, states) in self.encoder.layers.iter().zip(&mut self.now) {
            let length = self.modules * layer.width();
            states.all_mut()[slot * length..][..length].fill(0.0);
        }
        self.slots.push(start); // within capacity: a window leaves before as many others have come
    }

    /// Takes a slot's latents and gives its place to the last one.
    fn close(&mut self, slot: usize) -> &[f32] {
        let last = self.slots.len() - 1;
        let latents = self.encoder.latents();
        if let (Some(layer), Some(states)) = (self.encoder.layers.last(), self.now.last()) {
            let width = layer.width();
            let ended = states.all()[slot * self.modules * width..].chunks_exact(width);
            for (out, state) in self.latents.chunks_exact_mut(latents).zip(ended) {
                out.copy_from_slice(&state[..latents]);
            }
        }
        for (layer, states) in self.encoder.layers.iter().zip(&mut self.now) {
            let length = self.modules * layer.width();
            let states = states.all_mut();
            states.copy_within(last * length..(last + 1) * length, slot * length);
        }
        self.slots.swap_remove(slot);
        &self.latents
    }
}

/// One sample through everything in flight.
struct Hop<'a> {
    stream: &'a mut Stream,
    at: usize,
}

impl WithSimd for Hop<'_> {
    type Output = ();
    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let stream = self.stream;
        let encoder = &*stream.encoder;
        let (modules, stride) = (stream.modules, encoder.first_stride());
        let first = &encoder.layers[0];
        let newest = self.at * modules * stride;
        let inputs = Rows {
            values: &stream.scaled,
            stride: encoder.features(),
        };
        let ring = &mut *stream.ring;
        let samples = &mut ring[newest..];
        kernel::project_wide(
            simd,
            first,
            &encoder.first,
            inputs,
            modules,
            |module, at, sums| {
                samples[module * stride + at..][..sums.len()].copy_from_slice(sums);
            },
        );
        let columns = stream.slots.len() * modules;
        let mut begin = 0;
        while begin < columns {
            let group = (columns - begin).min(GROUP);
            for (c, sums) in stream.sums.all_mut()[..group * stride]
                .chunks_exact_mut(stride)
                .enumerate()
            {
                let (slot, module) = ((begin + c) / modules, (begin + c) % modules);
                let sample = &ring[newest + module * stride..][..stride];
                let start = &ring[(stream.slots[slot] * modules + module) * stride..][..stride];
                offset(sample, start, first.bias.all(), sums);
            }
            let mut input = Input::Summed(Rows {
                values: stream.sums.all(),
                stride,
            });
            let states = stream.now.iter().zip(&mut stream.next);
            for (layer, (now, next)) in encoder.layers.iter().zip(states) {
                let place = begin * layer.width();
                let next = &mut next.all_mut()[place..];
                kernel::step(simd, layer, input, &now.all()[place..], next, group);
                input = Input::Raw(Rows {
                    values: next,
                    stride: layer.width(),
                });
            }
            begin += group;
        }
    }
}
