//! What a model file has beside its encoder: the decoder, and how the file is written.

use palpate_core::texture::{Gru, Model};
use safetensors::tensor::TensorView;
use safetensors::{Dtype, SafeTensors};

use crate::error::FileError;
use crate::half::narrow;
use crate::texture_layer::{Layer, Tensor, tensor};
use crate::texture_model::{FORMAT, TextureModel, bytes};

/// The decoder of a model: a latent vector, repeated for every step of a window, through GRU layers and a linear one.
#[derive(Clone, Debug)]
pub struct TextureDecoder {
    layers: Vec<Layer>,
    /// Weights `[features, units]` of the linear layer.
    dense: Tensor,
    /// Biases of the linear layer.
    bias: Tensor,
}

impl TextureDecoder {
    /// The decoder of a built-in model or a model file that [`TextureModel::open`] has opened.
    ///
    /// # Errors
    /// A file without a decoder, or one whose parts do not fit together.
    pub fn open(name: &str, model: &TextureModel) -> Result<Self, FileError> {
        let (label, bytes) = bytes(name)?;
        let whole = |expected: &str, found: String| FileError::whole(&label, expected, found);
        let tensors = SafeTensors::deserialize(&bytes)
            .map_err(|e| whole("a model in safetensors", e.to_string()))?;
        let has = |number: usize| {
            let name = format!("decoder.{number}.weight_ih");
            tensors.tensor(&name).is_ok()
        };
        if !has(0) {
            let expected = "a model with a decoder, such as `thesis`";
            return Err(whole(expected, "an encoder alone".into()));
        }
        let count = (0..).take_while(|number| has(*number)).count();
        let layer = |number| Layer::read(&tensors, &label, ("decoder", number));
        let decoder = Self {
            layers: (0..count).map(layer).collect::<Result<_, _>>()?,
            dense: tensor(&tensors, &label, "dense.weight", 2)?,
            bias: tensor(&tensors, &label, "dense.bias", 1)?,
        };
        let fits = decoder.check(model);
        fits.map_err(|found| whole("a decoder that fits its encoder", found))?;
        Ok(decoder)
    }

    /// Checks that all layers fit together and that no weight could overflow, by the core's own check of layers.
    fn check(&self, model: &TextureModel) -> Result<(), String> {
        let none = vec![0.0; model.latents()];
        let layers: Vec<Gru<'_>> = self.layers.iter().map(Layer::gru).collect();
        let own = Model {
            scale_min: &none,
            scale_max: &none,
            layers: &layers,
            window: model.window(),
        };
        let encoder = palpate_core::texture::Encoder::new(&own);
        encoder.map_err(|e| e.to_string().replace("encoder.", "decoder."))?;
        let units = self.layers.last().map_or(0, Layer::units);
        let shape = [model.features(), units];
        let is_sound = |v: &f32| v.abs() <= 1e6; // no NaN is
        if self.dense.shape != shape || self.bias.values.len() != shape[0] {
            return Err(format!(
                "dense.weight of shape {:?} where {shape:?} fits",
                self.dense.shape
            ));
        }
        let mut all = self.dense.values.iter().chain(&self.bias.values);
        match all.all(is_sound) {
            true => Ok(()),
            false => Err("a weight of dense that is not finite or above a million".into()),
        }
    }

    /// The GRU layers, first to last.
    pub fn layers(&self) -> &[Layer] {
        &self.layers
    }

    /// The linear layer: weights `[features, units]`, row by row, and biases.
    pub fn dense(&self) -> (&[f32], &[f32]) {
        (&self.dense.values, &self.bias.values)
    }

    /// Trained numbers of the decoder.
    pub fn parameters(&self) -> usize {
        let layers: usize = self.layers.iter().map(Layer::parameters).sum();
        layers + self.dense.values.len() + self.bias.values.len()
    }
}

/// Precision of the weights in a model file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Precision {
    /// F32.
    Single,
    /// F16, of weights and biases alone: scaling and golden vector stay F32.
    Half,
}

/// The bytes of a model file: tensors by name, shape and numbers, and metadata beside the format; none where a shape
/// does not hold its numbers.
pub fn model_file(
    tensors: &[(String, Vec<usize>, &Vec<f32>)],
    metadata: &[(&str, String)],
    precision: Precision,
) -> Option<Vec<u8>> {
    let is_weight = |name: &str| !(name.starts_with("scale.") || name.starts_with("golden."));
    let kind = |name: &str| match precision {
        Precision::Half if is_weight(name) => Dtype::F16,
        _ => Dtype::F32,
    };
    let bytes = |name: &str, values: &Vec<f32>| -> Vec<u8> {
        match kind(name) {
            Dtype::F16 => values
                .iter()
                .flat_map(|v| narrow(*v).to_le_bytes())
                .collect(),
            _ => values.iter().flat_map(|v| v.to_le_bytes()).collect(),
        }
    };
    let data: Vec<_> = tensors.iter().map(|(name, _, v)| bytes(name, v)).collect();
    let mut views = Vec::new();
    for ((name, shape, _), data) in tensors.iter().zip(&data) {
        let view = TensorView::new(kind(name), shape.clone(), data);
        views.push((name, view.ok()?));
    }
    let metadata = metadata
        .iter()
        .map(|(key, text)| ((*key).to_owned(), text.clone()));
    let format = [("format".to_owned(), FORMAT.to_owned())];
    safetensors::serialize(views, Some(format.into_iter().chain(metadata).collect())).ok()
}
