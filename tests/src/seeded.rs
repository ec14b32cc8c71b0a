//! Models that have learnt nothing, and strokes of nothing: for benchmarks and tests, whose answers do not depend on
//! training.

use palpate_core::random::RandomStream;
use palpate_core::texture::{Encoder, Gru, Model};

/// A model that owns its numbers.
#[derive(Clone, Debug)]
pub struct Seeded {
    /// Smallest raw values, around 24 000.
    pub scale_min: Vec<f32>,
    /// Largest raw values, around 34 000.
    pub scale_max: Vec<f32>,
    /// The layers.
    pub layers: Vec<Layer>,
    /// Samples of a window.
    pub window: usize,
}

/// A layer's numbers, as in [`Gru`].
#[derive(Clone, Debug)]
pub struct Layer {
    /// Inputs I.
    pub inputs: usize,
    /// Units H.
    pub units: usize,
    /// `[3H, I]`.
    pub weight_ih: Vec<f32>,
    /// `[3H, H]`.
    pub weight_hh: Vec<f32>,
    /// `[3H]`.
    pub bias_ih: Vec<f32>,
    /// `[3H]`.
    pub bias_hh: Vec<f32>,
}

impl Seeded {
    /// `sizes` are the features and each layer's units; weights and biases uniform within `size` / sqrt(units), as
    /// networks are initialised with `size` 1.
    pub fn new(seed: u64, sizes: &[usize], window: usize, size: f64) -> Self {
        let mut draw = RandomStream::new(seed, "texture model");
        let mut uniform = |n: usize, range: f64| -> Vec<f32> {
            (0..n)
                .map(|_| ((2.0 * draw.uniform() - 1.0) * range) as f32)
                .collect()
        };
        let layers = sizes
            .iter()
            .zip(sizes.iter().skip(1))
            .map(|(&inputs, &units)| {
                let range = size / (units as f64).sqrt();
                Layer {
                    inputs,
                    units,
                    weight_ih: uniform(3 * units * inputs, range),
                    weight_hh: uniform(3 * units * units, range),
                    bias_ih: uniform(3 * units, range),
                    bias_hh: uniform(3 * units, range),
                }
            });
        let layers = layers.collect();
        let features = sizes.first().copied().unwrap_or(0);
        let mut about = |counts: f32| -> Vec<f32> {
            let values = uniform(features, 3000.0);
            values.iter().map(|v| counts + v).collect()
        };
        Self {
            scale_min: about(24_000.0),
            scale_max: about(34_000.0),
            layers,
            window,
        }
    }

    /// The encoder of Table 3.1 for 45 features.
    pub fn thesis(seed: u64) -> Self {
        Self::new(seed, &[45, 96, 96, 96, 3], 100, 1.0)
    }

    /// Calls `then` with the model as core takes it.
    pub fn with<T>(&self, then: impl FnOnce(&Model<'_>) -> T) -> T {
        let layers: Vec<_> = self
            .layers
            .iter()
            .map(|layer| Gru {
                inputs: layer.inputs,
                units: layer.units,
                weight_ih: &layer.weight_ih,
                weight_hh: &layer.weight_hh,
                bias_ih: &layer.bias_ih,
                bias_hh: &layer.bias_hh,
            })
            .collect();
        then(&Model {
            scale_min: &self.scale_min,
            scale_max: &self.scale_max,
            layers: &layers,
            window: self.window,
        })
    }

    /// As a model file whose golden vector is what the encoder gives; none where the model does not fit together.
    pub fn file(&self) -> Option<Vec<u8>> {
        self.file_with(&[])
    }

    /// The same with further metadata.
    pub fn file_with(&self, more: &[(&str, String)]) -> Option<Vec<u8>> {
        let encoder = self.with(Encoder::new).ok()?;
        let window = stroke(1, self.window, self.scale_min.len());
        let mut room = encoder.room();
        let latent = encoder.encode(&mut room, &window).ok()?.to_vec();
        let mut tensors = vec![
            (
                "scale.min".to_owned(),
                vec![encoder.features()],
                &self.scale_min,
            ),
            (
                "scale.max".to_owned(),
                vec![encoder.features()],
                &self.scale_max,
            ),
            (
                "golden.window".to_owned(),
                vec![self.window, encoder.features()],
                &window,
            ),
            ("golden.latent".to_owned(), vec![encoder.latents()], &latent),
        ];
        for (l, layer) in self.layers.iter().enumerate() {
            let (rows, name) = (3 * layer.units, |what: &str| format!("encoder.{l}.{what}"));
            tensors.push((
                name("weight_ih"),
                vec![rows, layer.inputs],
                &layer.weight_ih,
            ));
            tensors.push((name("weight_hh"), vec![rows, layer.units], &layer.weight_hh));
            tensors.push((name("bias_ih"), vec![rows], &layer.bias_ih));
            tensors.push((name("bias_hh"), vec![rows], &layer.bias_hh));
        }
        let latent = r#"{"roughness":{"coordinate":0,"sign":1,"z_lo":-0.5,"z_hi":0.5}}"#;
        let mut about = more.to_vec();
        about.push(("window", self.window.to_string()));
        if !more.iter().any(|(key, _)| *key == "latent") {
            about.push(("latent", latent.to_owned()));
        }
        palpate_files::model_file(&tensors, &about, palpate_files::Precision::Single)
    }
}

/// Raw counts `[sample][feature]` that look like a stroke: an offset, slow waves, noise.
pub fn stroke(seed: u64, samples: usize, features: usize) -> Vec<f32> {
    let mut draw = RandomStream::new(seed, "stroke");
    let shape: Vec<[f64; 3]> = (0..features)
        .map(|_| [draw.uniform(), draw.uniform(), draw.uniform()])
        .collect();
    let mut values = Vec::with_capacity(samples * features);
    for t in 0..samples {
        for [offset, rate, phase] in &shape {
            let wave = libm::sin(t as f64 * (0.05 + 0.6 * rate) + 6.0 * phase);
            let counts = 26_000.0 + 6000.0 * offset + 1500.0 * wave + 60.0 * draw.normal();
            values.push(counts.round() as f32);
        }
    }
    values
}
