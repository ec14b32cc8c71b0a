//! The way back: windows that a model's decoder rebuilds from latent vectors, and how far they are from those that were
//! encoded.

use palpate_core::texture::Encoder;
use palpate_emulators::sensor::surface::Recording;
use palpate_files::{Layer, Split, TextureDecoder, TextureEntry, TextureModel};
use palpate_run::Failure;
use rayon::prelude::*;

use crate::explore::{STROKED_HZ, features};

/// Rows between windows that are rebuilt: neighbours are nearly the same.
const HOP: usize = 10;

/// One layer with its weights column by column: the weights of one input lie side by side.
struct Columns {
    inputs: Vec<f32>,
    states: Vec<f32>,
    bias_inputs: Vec<f32>,
    bias_states: Vec<f32>,
    units: usize,
}

/// A decoder that is ready to run, with its encoder.
pub struct Rebuilder<'a> {
    model: &'a TextureModel,
    encoder: Encoder,
    layers: Vec<Columns>,
    dense: Vec<f32>,
    bias: Vec<f32>,
}

/// Transposes weights of `rows` rows.
fn columns(weights: &[f32], rows: usize) -> Vec<f32> {
    let width = weights.len() / rows.max(1);
    let column = |c: usize| weights.iter().skip(c).step_by(width.max(1)).copied();
    (0..width).flat_map(column).collect()
}

/// `sums` begin as biases; every input adds its column.
fn project(columns: &[f32], bias: &[f32], inputs: &[f32], sums: &mut Vec<f32>) {
    sums.clear();
    sums.extend_from_slice(bias);
    for (column, x) in columns.chunks_exact(bias.len()).zip(inputs) {
        sums.iter_mut()
            .zip(column)
            .for_each(|(sum, w)| *sum += w * x);
    }
}

fn logistic(x: f32) -> f32 {
    1.0 / (1.0 + (-x).exp())
}

impl Columns {
    fn new(layer: &Layer) -> Self {
        let units = layer.units();
        Self {
            inputs: columns(&layer.weight_ih.values, 3 * units),
            states: columns(&layer.weight_hh.values, 3 * units),
            bias_inputs: layer.bias_ih.values.clone(),
            bias_states: layer.bias_hh.values.clone(),
            units,
        }
    }

    /// States of every step, one after another, for as many inputs.
    fn run(&self, inputs: &[f32], steps: usize) -> Vec<f32> {
        let (units, width) = (self.units, inputs.len() / steps.max(1));
        let mut all = Vec::with_capacity(steps * units);
        let mut state = vec![0.0; units];
        let (mut from_input, mut from_state) = (Vec::new(), Vec::new());
        for x in inputs.chunks_exact(width.max(1)) {
            project(&self.inputs, &self.bias_inputs, x, &mut from_input);
            project(&self.states, &self.bias_states, &state, &mut from_state);
            for (unit, h) in state.iter_mut().enumerate() {
                let [reset, update] =
                    [unit, units + unit].map(|i| logistic(from_input[i] + from_state[i]));
                let i = 2 * units + unit;
                let new = (from_input[i] + reset * from_state[i]).tanh();
                *h = (1.0 - update) * new + update * *h;
            }
            all.extend_from_slice(&state);
        }
        all
    }
}

impl<'a> Rebuilder<'a> {
    /// Makes a model and its decoder ready.
    ///
    /// # Errors
    /// A model whose encoder does not fit together.
    pub fn new(model: &'a TextureModel, decoder: &TextureDecoder) -> Result<Self, Failure> {
        let (dense, bias) = decoder.dense();
        Ok(Self {
            model,
            encoder: model.encoder()?,
            layers: decoder.layers().iter().map(Columns::new).collect(),
            dense: columns(dense, bias.len()),
            bias: bias.to_vec(),
        })
    }

    /// The window `[sample][feature]` that the decoder makes of a latent vector: shares of each feature's range, less the
    /// window's first sample.
    pub fn decode(&self, latent: &[f32]) -> Vec<f32> {
        let steps = self.encoder.window();
        let repeated = latent.repeat(steps);
        let layers = self.layers.iter();
        let states = layers.fold(repeated, |inputs, layer| layer.run(&inputs, steps));
        let mut all = Vec::with_capacity(steps * self.bias.len());
        let mut row = Vec::new();
        for state in states.chunks_exact((states.len() / steps).max(1)) {
            project(&self.dense, &self.bias, state, &mut row);
            all.extend_from_slice(&row);
        }
        all
    }

    /// Mean squared error of the window that comes back from `samples`, `[sample][feature]` in raw counts: of shares of each
    /// feature's range, as in training.
    ///
    /// # Errors
    /// Samples that the encoder refuses.
    pub fn error(&self, samples: &[f32]) -> Result<f64, Failure> {
        let mut room = self.encoder.room();
        let refused = |e| Failure::Input(format!("a window: {e}"));
        let latent = self.encoder.encode(&mut room, samples).map_err(refused)?;
        let rebuilt = self.decode(latent);
        let count = self.encoder.features();
        let factors: Vec<f32> = self.model.with(|model| model.factors().collect());
        let first = samples.iter().take(count);
        let offset: Vec<(f32, f32)> = first.copied().zip(factors).collect();
        let given = samples.iter().zip(offset.iter().cycle());
        let given = given.map(|(raw, (first, factor))| (raw - first) * factor);
        let squares = given.zip(&rebuilt).map(|(a, b)| f64::from(a - b).powi(2));
        Ok(squares.sum::<f64>() / samples.len().max(1) as f64)
    }

    /// [`Rebuilder::strokes`] of those that have this part in the training. A test takes every window, as in training.
    ///
    /// # Errors
    /// Errors of [`Rebuilder::strokes`].
    pub fn part(
        &self,
        strokes: &[(&TextureEntry, Recording)],
        split: &Split,
        part: Part,
    ) -> Result<Rebuilt, Failure> {
        let own = strokes.iter();
        let own = own.filter(|(entry, stroke)| Part::named_in(split, entry, stroke) == part);
        let own: Vec<&Recording> = own.map(|(_, stroke)| stroke).collect();
        self.strokes(&own, if part == Part::Test { 1 } else { HOP })
    }

    /// Mean of [`Rebuilder::error`] over windows of strokes that begin `hop` rows apart, and the number of windows.
    ///
    /// # Errors
    /// A model for other features or another rate than those of emulated strokes.
    pub fn strokes(&self, strokes: &[&Recording], hop: usize) -> Result<Rebuilt, Failure> {
        self.model.check_rate(STROKED_HZ)?;
        let length = self.encoder.window() * self.encoder.features();
        let mut windows = Vec::new();
        let values: Vec<Vec<f32>> = strokes
            .iter()
            .map(|stroke| features(self.model, stroke))
            .collect::<Result<_, _>>()?;
        for stroke in &values {
            let all = stroke.windows(length.max(1));
            windows.extend(all.step_by(hop.max(1) * self.encoder.features()));
        }
        let errors = windows.par_iter().map(|window| self.error(window));
        let errors: Vec<f64> = errors.collect::<Result<_, _>>()?;
        Ok(Rebuilt {
            windows: errors.len(),
            error: errors.iter().sum::<f64>() / errors.len().max(1) as f64,
        })
    }
}

/// Error of reconstruction over some windows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rebuilt {
    /// Windows that were rebuilt.
    pub windows: usize,
    /// Mean squared error, in shares of each feature's range.
    pub error: f64,
}

/// Part that a stroke has in a model's training, by its file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Part {
    /// Strokes that the model learned from.
    Training,
    /// Strokes whose error ended the training.
    Validation,
    /// Strokes whose error is stated as the model's.
    Test,
    /// Strokes of textures that the training had none of.
    Unseen,
}

impl Part {
    /// Every part, in the order of the training.
    pub const ALL: [Self; 4] = [Self::Training, Self::Validation, Self::Test, Self::Unseen];

    /// The part in a word.
    pub const fn word(self) -> &'static str {
        match self {
            Self::Training => "training",
            Self::Validation => "validation",
            Self::Test => "test",
            Self::Unseen => "unseen",
        }
    }

    /// The part of a stroke by [`TextureModel::split`] and the name of its recording.
    pub fn named_in(split: &Split, entry: &TextureEntry, stroke: &Recording) -> Self {
        let name = format!("{}_{:02}", entry.name, stroke.number);
        let parts = [
            (&split.train, Self::Training),
            (&split.validation, Self::Validation),
            (&split.test, Self::Test),
        ];
        let own = parts.iter().find(|(names, _)| names.contains(&name));
        own.map_or(Self::Unseen, |(_, part)| *part)
    }
}

#[cfg(test)]
#[path = "rebuild_tests.rs"]
mod tests;
