//! Ground for the measurements of the encoder: the model that ships, and emulated strokes that its training never
//! saw.

use palpate_core::texture::Encoder;
use palpate_files::{TextureModel, load_textures};
use palpate_run::Failure;
use palpate_tests::reference;
use palpate_texture::explore;

/// Strokes over each texture, one after another as one recording.
const STROKES: u32 = 3;
/// Seed of the strokes; the model was trained on those of seed 1.
const SEED: u64 = 2;
/// Samples from one window of a stroke to the next: the first holds the impact, the others do not.
const APART: usize = 37;

/// A model, a recording, windows of it and their latents in f64.
pub struct Ground {
    pub model: TextureModel,
    /// The strokes, row after row.
    pub values: Vec<f32>,
    pub windows: Vec<Vec<f32>>,
    expected: Vec<Vec<f64>>,
}

impl Ground {
    /// Strokes over the thesis's textures and the default model.
    ///
    /// # Errors
    /// A model or a table that is refused.
    pub fn new() -> Result<Self, Failure> {
        let model = TextureModel::open("default")?;
        let table = load_textures("thesis")?.value;
        let (row, length) = (model.features(), model.window());
        let (mut values, mut ends) = (Vec::new(), Vec::new());
        for (_, recording) in explore::explore(&table, STROKES, SEED, |_| ()) {
            let first = values.len() / row + length - 1;
            values.extend(explore::features(&model, &recording)?);
            ends.extend((first..values.len() / row).step_by(APART));
        }
        let windows: Vec<Vec<f32>> = ends
            .iter()
            .map(|end| values[(end + 1 - length) * row..(end + 1) * row].to_vec())
            .collect();
        let expected = model.with(|m| windows.iter().map(|w| reference::encode(m, w)).collect());
        Ok(Self {
            model,
            values,
            windows,
            expected,
        })
    }

    /// Smallest and largest latent value of the windows: what errors are to be seen against.
    pub fn range(&self) -> (f64, f64) {
        let values = self.expected.iter().flatten();
        values.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), &z| {
            (low.min(z), high.max(z))
        })
    }

    /// Largest error of latents, over all windows.
    pub fn off(&self, found: &[Vec<f32>]) -> f64 {
        let pairs = found.iter().zip(&self.expected);
        pairs
            .flat_map(|(found, expected)| found.iter().zip(expected))
            .map(|(found, expected)| (f64::from(*found) - expected).abs())
            .map(|off| if off.is_nan() { f64::INFINITY } else { off })
            .fold(0.0, f64::max)
    }

    /// Largest error of an encoder's latents, window by window.
    pub fn off_by(&self, encoder: &Encoder) -> f64 {
        let mut room = encoder.room();
        let found: Vec<Vec<f32>> = self
            .windows
            .iter()
            .map(|w| {
                encoder
                    .encode(&mut room, w)
                    .map(<[f32]>::to_vec)
                    .unwrap_or_default()
            })
            .collect();
        self.off(&found)
    }
}
