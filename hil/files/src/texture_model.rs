//! Model files: safetensors with PyTorch's names and gate order, and a golden vector that the model must give.

use std::borrow::Cow;
use std::collections::BTreeMap;
use std::path::Path;

use palpate_core::texture::{Drivers, Encoder, Gru, LatentDriver, Model};
use palpate_core::vector::Vectors;
use safetensors::SafeTensors;
use serde::Deserialize;

use crate::error::FileError;
use crate::felt::DrivenBy;
use crate::reading::read_bytes;
use crate::texture::TextureEntry;
use crate::texture_layer::{Layer, Tensor, tensor};

/// The `format` that this program reads.
pub(crate) const FORMAT: &str = "palpate-texture 1";
/// Largest deviation of the golden vector.
const GOLDEN: f64 = 1e-5;
/// Largest model file: a larger one is some other file.
const MOST_BYTES: u64 = 256 << 20;

/// Taxel, from 0, and axis of a column that is called `txl1_x`.
pub fn taxel(column: &str) -> Option<(usize, usize)> {
    let (taxel, axis) = column.strip_prefix("txl")?.split_once('_')?;
    let taxel = taxel.parse::<usize>().ok()?.checked_sub(1)?;
    Some((taxel, ["x", "y", "z"].iter().position(|a| *a == axis)?))
}

/// A model whose golden vector came out right.
#[derive(Clone, Debug)]
pub struct TextureModel {
    label: String,
    layers: Vec<Layer>,
    scale_min: Vec<f32>,
    scale_max: Vec<f32>,
    window: usize,
    names: Vec<String>,
    metadata: BTreeMap<String, String>,
}

/// Meaning of one latent coordinate.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
pub struct Stands {
    /// Number of the coordinate, from 0.
    pub coordinate: usize,
    /// Sign of the relation; -1: the property falls where the coordinate grows.
    pub sign: i32,
    z_lo: f32,
    z_hi: f32,
    /// Smallest and largest of the property in the training, where that knew the surfaces: um of relief, N/mm of
    /// stiffness, a coefficient of friction.
    pub learned: Option<[f64; 2]>,
}

impl Stands {
    /// The coordinate as a driver of wires.
    pub const fn driver(self) -> LatentDriver {
        LatentDriver {
            coordinate: self.coordinate,
            falls: self.sign < 0,
            low: self.z_lo,
            high: self.z_hi,
        }
    }
}

/// Coordinates with a meaning.
#[derive(Clone, Copy, Debug, Default, PartialEq, Deserialize)]
pub struct Standing {
    /// Roughness.
    pub roughness: Option<Stands>,
    /// Hardness.
    pub hardness: Option<Stands>,
    /// Friction; models that were trained by ratings have none.
    pub friction: Option<Stands>,
    /// z1 itself, with the direction and the range of what it goes with most nearly.
    pub first: Option<Stands>,
}

/// Recordings of each part of a training, by name.
#[derive(Clone, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(default)]
pub struct Split {
    /// Recordings that it learned from.
    pub train: Vec<String>,
    /// Recordings that it was measured with.
    pub test: Vec<String>,
    /// Recordings that stopped it.
    pub validation: Vec<String>,
}

impl TextureModel {
    /// The built-in model called `default` or `thesis`, or a file.
    ///
    /// # Errors
    /// A file that cannot be read, is no such model, or misses its golden vector.
    pub fn open(name: &str) -> Result<Self, FileError> {
        let (label, bytes) = bytes(name)?;
        Self::parse(&label, &bytes)
    }

    /// Parses a model from the bytes of its file; `label` names it in errors.
    ///
    /// # Errors
    /// The errors of [`TextureModel::open`].
    pub fn parse(label: &str, bytes: &[u8]) -> Result<Self, FileError> {
        let wrong = |key: &str, expected: String, found: String| FileError {
            key: Some(key.to_owned()),
            ..FileError::whole(label, expected, found)
        };
        let whole = |found: String| FileError::whole(label, "a model in safetensors", found);
        let tensors = SafeTensors::deserialize(bytes).map_err(|e| whole(e.to_string()))?;
        let (_, header) = SafeTensors::read_metadata(bytes).map_err(|e| whole(e.to_string()))?;
        let metadata: BTreeMap<String, String> = header
            .metadata()
            .iter()
            .flatten()
            .map(|(k, v)| (k.clone(), v.clone()))
            .collect();
        let text = |key: &str| metadata.get(key).map_or("", String::as_str);
        if text("format") != FORMAT {
            let found = format!("{:?}", text("format"));
            return Err(wrong("metadata.format", format!("{FORMAT:?}"), found));
        }
        let window: usize = text("window").parse().map_err(|_| {
            wrong(
                "metadata.window",
                "a number of samples".into(),
                format!("{:?}", text("window")),
            )
        })?;
        let read = |key: &str, dimensions| tensor(&tensors, label, key, dimensions);
        let mut layers = Vec::new();
        while layers.is_empty()
            || tensors
                .tensor(&format!("encoder.{}.weight_ih", layers.len()))
                .is_ok()
        {
            layers.push(Layer::read(&tensors, label, ("encoder", layers.len()))?);
        }
        let model = Self {
            label: label.into(),
            layers,
            scale_min: read("scale.min", 1)?.values,
            scale_max: read("scale.max", 1)?.values,
            window,
            names: names(text("features")),
            metadata,
        };
        let golden = (read("golden.window", 2)?, read("golden.latent", 1)?);
        model.check(&golden.0, &golden.1)?;
        Ok(model)
    }

    /// Checks that the golden window gives the golden latent vector.
    fn check(&self, window: &Tensor, latent: &Tensor) -> Result<(), FileError> {
        let wrong = |key: &str, expected: String, found: String| FileError {
            key: Some(key.to_owned()),
            ..FileError::whole(&self.label, expected, found)
        };
        let encoder = self.encoder()?;
        let shape = [encoder.window(), encoder.features()];
        if window.shape != shape {
            let found = format!("{:?}", window.shape);
            return Err(wrong("golden.window", format!("shape {shape:?}"), found));
        }
        if latent.values.len() != encoder.latents() {
            let expected = format!("{} numbers", encoder.latents());
            return Err(wrong(
                "golden.latent",
                expected,
                latent.values.len().to_string(),
            ));
        }
        let mut room = encoder.room();
        let found = encoder.encode(&mut room, &window.values).map_err(|e| {
            wrong(
                "golden.window",
                "a window of raw counts".into(),
                e.to_string(),
            )
        })?;
        let off = |(a, b): (&f32, &f32)| (f64::from(*a) - f64::from(*b)).abs();
        for (i, pair) in found.iter().zip(&latent.values).enumerate() {
            let near = off(pair) <= GOLDEN; // no NaN is
            if !near {
                return Err(wrong(
                    &format!("golden.latent[{i}]"),
                    format!(
                        "{} as the encoder computes it, to {GOLDEN:e} (was the model converted? see docs/texture.md)",
                        pair.0
                    ),
                    pair.1.to_string(),
                ));
            }
        }
        Ok(())
    }

    /// Calls `then` with the model in the core's type.
    pub fn with<T>(&self, then: impl FnOnce(&Model<'_>) -> T) -> T {
        let layers: Vec<Gru<'_>> = self.layers.iter().map(Layer::gru).collect();
        then(&Model {
            scale_min: &self.scale_min,
            scale_max: &self.scale_max,
            layers: &layers,
            window: self.window,
        })
    }

    /// The encoder.
    ///
    /// # Errors
    /// Shapes that do not fit each other, numbers out of bounds.
    pub fn encoder(&self) -> Result<Encoder, FileError> {
        self.encoder_on(Vectors::widest())
    }

    /// The encoder on vectors of choice, which change its speed and no bit.
    ///
    /// # Errors
    /// The errors of [`TextureModel::encoder`].
    pub fn encoder_on(&self, vectors: Vectors) -> Result<Encoder, FileError> {
        self.with(|model| Encoder::with(model, vectors))
            .map_err(|e| FileError::whole(&self.label, "a model that fits together", e.to_string()))
    }

    /// Meanings of the coordinates by the file's `latent`; nothing of those that this model lacks.
    pub fn standing(&self) -> Standing {
        let text = self.metadata.get("latent").map_or("", String::as_str);
        let found: Standing = serde_json::from_str(text).unwrap_or_default();
        let real = |one: Option<Stands>| one.filter(|s| s.coordinate < self.latents());
        let named = [found.first, found.roughness, found.friction, found.hardness];
        let mut named = named.into_iter().flatten();
        Standing {
            roughness: real(found.roughness),
            hardness: real(found.hardness),
            friction: real(found.friction),
            first: named.find(|stands| stands.coordinate == 0),
        }
    }

    /// Returns true if recordings of this label were among those that the model was trained on; `None` where its file
    /// names none.
    pub fn was_trained_on(&self, label: &str) -> Option<bool> {
        let of = |name: &String| name.rsplit_once('_').is_some_and(|(own, _)| own == label);
        Some(self.split()?.train.iter().any(of))
    }

    /// Recordings of each part of the training, where the file names them.
    pub fn split(&self) -> Option<Split> {
        serde_json::from_str(self.metadata.get("split")?).ok()
    }

    /// Properties of a surface that lie outside what the model learned, a twentieth aside, in a few words each; none
    /// where its training did not know the surfaces.
    pub fn extrapolated(&self, surface: &TextureEntry) -> Vec<String> {
        let standing = self.standing();
        let asked = [
            (standing.roughness, "relief", surface.relief_um, " um"),
            (standing.friction, "friction", surface.friction, ""),
            (
                standing.hardness,
                "stiffness",
                surface.stiffness_n_per_mm,
                " N/mm",
            ),
        ];
        let outside = |(stands, name, value, unit): (Option<Stands>, &str, f64, &str)| {
            let [low, high] = stands?.learned?;
            let is_in = low * 0.95 <= value && value <= high * 1.05;
            (!is_in).then(|| format!("{name} {value}{unit} (learned {low} to {high})"))
        };
        asked.into_iter().filter_map(outside).collect()
    }

    /// The latent coordinates that drive wires: by their meaning the one of roughness, and those of friction and hardness
    /// where there are such; or z1 alone.
    ///
    /// # Errors
    /// A model without a coordinate of roughness, which was not trained here, or without a range of z1.
    pub fn drivers(&self, by: DrivenBy) -> Result<Drivers, FileError> {
        let found = self.standing();
        let text = self.metadata.get("latent").map_or("", String::as_str);
        let (drivers, name) = match by {
            DrivenBy::First => (found.first.map(|z1| Drivers::from(z1.driver())), "first"),
            DrivenBy::Meaning => {
                let drivers = found.roughness.map(|roughness| Drivers {
                    roughness: roughness.driver(),
                    friction: found.friction.map(Stands::driver),
                    hardness: found.hardness.map(Stands::driver),
                });
                (drivers, "roughness")
            }
        };
        drivers.ok_or_else(|| FileError {
            key: Some("metadata.latent".into()),
            ..FileError::whole(
                &self.label,
                format!(
                    "{name} {{coordinate, sign, z_lo, z_hi}}, as a training with ratings writes it"
                ),
                if text.is_empty() { "nothing" } else { text },
            )
        })
    }

    /// Readings per second of the recordings that it was trained on, where the file states it.
    pub fn rate_hz(&self) -> Option<f64> {
        let rate: f64 = self.metadata.get("rate_hz")?.parse().ok()?;
        (rate.is_finite() && rate > 0.0).then_some(rate)
    }

    /// Checks that readings at `rate_hz` have the rate of the training, within a hundredth.
    ///
    /// Another rate: a window would last longer or shorter, and ripples in it would change.
    pub fn check_rate(&self, rate_hz: f64) -> Result<(), FileError> {
        match self.rate_hz() {
            Some(trained) if (rate_hz / trained - 1.0).abs() > 0.01 => Err(FileError {
                key: Some("metadata.rate_hz".into()),
                ..FileError::whole(
                    &self.label,
                    format!("readings at {trained} Hz, which this model was trained on"),
                    format!("{rate_hz} Hz"),
                )
            }),
            _ => Ok(()),
        }
    }

    /// The encoder's layers.
    pub fn layers(&self) -> &[Layer] {
        &self.layers
    }

    /// Values of a sample.
    pub fn features(&self) -> usize {
        self.scale_min.len()
    }

    /// Values of a latent vector.
    pub fn latents(&self) -> usize {
        self.layers.last().map_or(0, Layer::units)
    }

    /// Samples of a window.
    pub const fn window(&self) -> usize {
        self.window
    }

    /// The columns of a recording that are the features; empty where the file does not name them all.
    pub fn feature_names(&self) -> &[String] {
        if self.names.len() == self.features() {
            &self.names
        } else {
            &[]
        }
    }

    /// Further entries of the file's metadata.
    pub const fn metadata(&self) -> &BTreeMap<String, String> {
        &self.metadata
    }
}

/// Label in errors, and bytes, of a built-in model or a model file.
///
/// # Errors
/// A file that cannot be read.
pub(crate) fn bytes(name: &str) -> Result<(String, Cow<'static, [u8]>), FileError> {
    if let Some(bytes) = palpate_fixtures::model(name) {
        return Ok((format!("fixtures/models/{name}.safetensors"), bytes.into()));
    }
    let expected = "`default`, `thesis` or a model file";
    let bytes = read_bytes(Path::new(name), expected, MOST_BYTES)?;
    Ok((name.to_owned(), bytes.into()))
}

/// A JSON list of names, or names between commas.
fn names(text: &str) -> Vec<String> {
    serde_json::from_str(text).unwrap_or_else(|_| {
        let names = text.split(',').map(str::trim).filter(|n| !n.is_empty());
        names.map(str::to_owned).collect()
    })
}
