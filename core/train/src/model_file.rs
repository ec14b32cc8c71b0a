//! The model file: safetensors in PyTorch's names and gate order, with everything needed to use it and to doubt it.

use std::collections::HashMap;
use std::path::Path;

use burn::module::Param;
use burn::prelude::*;
use palpate_emulators::surface::spearman;
use safetensors::SafeTensors;
use safetensors::tensor::{Dtype, TensorView};
use serde::Serialize;
use serde_json::{Value, json};

use crate::failure::Failure;
use crate::network::Network;
use crate::recordings::Rating;
use crate::training::{Plain, Progress, Settings, latents};
use crate::windows::{Place, Split, Windows};

/// The `format` entry of a model file.
pub const FORMAT: &str = "palpate-texture 1";

/// What a model file says besides its weights.
pub struct About<'a> {
    pub windows: &'a Windows,
    pub split: &'a Split,
    pub settings: &'a Settings,
    pub progress: &'a Progress,
    /// Mean squared error over every window of the test recordings.
    pub test_error: f64,
    pub latent: Latent,
    /// The command line that made it.
    pub command: String,
    pub revision: String,
}

/// Which latent coordinate stands for what, by rank correlation over the training recordings.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Latent {
    /// Drives mu, sigma and f_PWM.
    pub roughness: Option<Driver>,
    pub hardness: Option<Driver>,
}

/// A latent coordinate, which way it grows, and its range (5th to 95th percentile of the training windows).
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Driver {
    pub coordinate: usize,
    pub sign: i32,
    /// What it was chosen by: [`RATINGS`] or [`BUZZ`].
    pub with: &'static str,
    /// Spearman's rank correlation with that.
    pub spearman: f64,
    pub z_lo: f32,
    pub z_hi: f32,
}

/// What people say of the labels.
const RATINGS: &str = "ratings";
/// Nobody rated these recordings: how much readings change from row to row, which is what rough surfaces do to them.
const BUZZ: &str = "buzz";

/// Finds what drives roughness (its mean with friction, as the thesis reads z1; the buzz where there are no ratings)
/// and hardness.
pub fn drivers(
    network: &Network<Plain>,
    windows: &Windows,
    train: &[usize],
    ratings: &[Rating],
) -> Latent {
    let places = windows.of(train, 4);
    let latents = latents(network, windows, &places);
    let Some(width) = latents.first().map(Vec::len) else {
        return Latent::default();
    };
    let rated = |of: fn(&Rating) -> f32| -> Option<Vec<f64>> {
        let rating = |place: &Place| {
            let label = &windows.recording(*place).label;
            let rating = ratings.iter().find(|r| r.label == *label)?;
            Some(f64::from(of(rating)))
        };
        places.iter().map(rating).collect()
    };
    let driver = |(with, rated): (&'static str, Vec<f64>)| {
        let found = (0..width).map(|coordinate| {
            let mut z: Vec<f64> = latents.iter().map(|z| f64::from(z[coordinate])).collect();
            let spearman = spearman(&z, &rated);
            z.sort_by(f64::total_cmp);
            Driver {
                coordinate,
                sign: if spearman < 0.0 { -1 } else { 1 },
                with,
                spearman,
                z_lo: z[z.len() / 20] as f32,
                z_hi: z[z.len() - 1 - z.len() / 20] as f32,
            }
        });
        found.max_by(|a, b| a.spearman.abs().total_cmp(&b.spearman.abs()))
    };
    let roughness = rated(|r| (r.roughness + r.friction) / 2.0).map(|rated| (RATINGS, rated));
    let buzz = || (BUZZ, places.iter().map(|&p| buzz(windows, p)).collect());
    Latent {
        roughness: driver(roughness.unwrap_or_else(buzz)),
        hardness: rated(|r| r.hardness).and_then(|rated| driver((RATINGS, rated))),
    }
}

/// Mean change from row to row over a window, in shares of the features' ranges.
fn buzz(windows: &Windows, place: Place) -> f64 {
    let (raw, scale) = (windows.raw(place), &windows.scale);
    let features = scale.min.len();
    let changes = raw.iter().zip(&raw[features..]).enumerate();
    let sum: f64 = changes
        .map(|(i, (before, now))| {
            let span = scale.max[i % features] - scale.min[i % features];
            f64::from((now - before).abs() / span)
        })
        .sum();
    sum / (raw.len() - features).max(1) as f64
}

/// Writes a model file, whole or not at all.
pub fn write(path: &Path, network: &Network<Plain>, about: &About<'_>) -> Result<(), Failure> {
    let mut tensors: Vec<(String, Vec<usize>, Vec<u8>)> = Vec::new();
    let mut add = |name: String, shape: Vec<usize>, values: &[f32]| {
        tensors.push((
            name,
            shape,
            values.iter().flat_map(|v| v.to_le_bytes()).collect(),
        ));
    };
    fn of<const D: usize>(param: &Param<Tensor<Plain, D>>) -> (Vec<usize>, Vec<f32>) {
        let tensor = param.val();
        let shape = tensor.dims().to_vec();
        (
            shape,
            tensor.into_data().into_vec().expect("training is in f32"),
        )
    }
    for (stack, layers) in [("encoder", &network.encoder), ("decoder", &network.decoder)] {
        for (number, layer) in layers.iter().enumerate() {
            let parts = [
                ("weight_ih", of(&layer.weight_ih)),
                ("weight_hh", of(&layer.weight_hh)),
                ("bias_ih", of(&layer.bias_ih)),
                ("bias_hh", of(&layer.bias_hh)),
            ];
            for (part, (shape, values)) in parts {
                add(format!("{stack}.{number}.{part}"), shape, &values);
            }
        }
    }
    for (name, (shape, values)) in [
        ("weight", of(&network.dense_weight)),
        ("bias", of(&network.dense_bias)),
    ] {
        add(format!("dense.{name}"), shape, &values);
    }
    let windows = about.windows;
    let features = windows.recordings.columns.len();
    add("scale.min".into(), vec![features], &windows.scale.min);
    add("scale.max".into(), vec![features], &windows.scale.max);
    // The golden vector: the first window of the first test recording.
    let golden = windows.of(&about.split.test, 1).first().copied();
    let golden = golden
        .ok_or_else(|| Failure::Usage("no test recording to take a golden vector from".into()))?;
    add(
        "golden.window".into(),
        vec![windows.length, features],
        windows.raw(golden),
    );
    let latent = latents(network, windows, &[golden]).swap_remove(0);
    add("golden.latent".into(), vec![latent.len()], &latent);

    let split = parts(windows, about.split);
    let progress = about.progress;
    let at = |errors: &[f64]| errors.get(progress.best_epoch.saturating_sub(1)).copied();
    let losses = json!({
        "epochs": progress.epochs,
        "best_epoch": progress.best_epoch,
        "train": at(&progress.train),
        "validation": at(&progress.validation),
        "test": about.test_error,
    });
    let metadata = HashMap::from(
        [
            ("format", FORMAT.to_owned()),
            ("features", json!(windows.recordings.columns).to_string()),
            ("window", windows.length.to_string()),
            ("seed", about.settings.seed.to_string()),
            ("settings", json!(about.settings).to_string()),
            ("split", split.to_string()),
            ("losses", losses.to_string()),
            ("latent", json!(about.latent).to_string()),
            ("command", about.command.clone()),
            ("revision", about.revision.clone()),
        ]
        .map(|(key, value)| (key.to_owned(), value)),
    );
    let mut views = Vec::new();
    for (name, shape, bytes) in &tensors {
        let view = TensorView::new(Dtype::F32, shape.clone(), bytes)
            .map_err(|e| Failure::file(path, e))?;
        views.push((name.as_str(), view));
    }
    let bytes =
        safetensors::serialize(views, Some(metadata)).map_err(|e| Failure::file(path, e))?;
    let partial = path.with_extension("partial");
    std::fs::write(&partial, bytes)
        .and_then(|()| std::fs::rename(&partial, path))
        .map_err(|e| Failure::file(path, e))
}

/// The recordings of a split by name, as a model file tells them.
fn parts(windows: &Windows, split: &Split) -> Value {
    let names = |part: &[usize]| -> Vec<&str> {
        part.iter()
            .map(|&r| windows.recordings.all[r].name.as_str())
            .collect()
    };
    json!({
        "train": names(&split.train),
        "test": names(&split.test),
        "validation": names(&split.validation),
    })
}

/// Puts a model file's weights into a network of the same shape, to train on from there. The model must have been
/// trained on the same part of the same recordings: else it would know what is to be held out.
pub fn weights<B: Backend>(
    path: &Path,
    mut network: Network<B>,
    windows: &Windows,
    split: &Split,
) -> Result<Network<B>, Failure> {
    let bad = |what: &dyn ToString| Failure::file(path, what.to_string());
    let bytes = std::fs::read(path).map_err(|e| bad(&e))?;
    let (_, header) = SafeTensors::read_metadata(&bytes).map_err(|e| bad(&e))?;
    let file = SafeTensors::deserialize(&bytes).map_err(|e| bad(&e))?;
    let told = header
        .metadata()
        .as_ref()
        .and_then(|about| serde_json::from_str::<Value>(about.get("split")?).ok());
    if told != Some(parts(windows, split)) {
        return Err(bad(
            &"expected a model trained on the same split of the same recordings: give its --seed, --split and folder",
        ));
    }
    fn take<B: Backend, const D: usize>(
        file: &SafeTensors<'_>,
        name: &str,
        param: &mut Param<Tensor<B, D>>,
    ) -> Result<(), String> {
        let dims = param.dims();
        let found = file.tensor(name).map_err(|e| format!("{name}: {e}"))?;
        if found.shape() != dims || found.dtype() != Dtype::F32 {
            let (shape, kind) = (found.shape(), found.dtype());
            return Err(format!(
                "{name}: expected f32 {dims:?}, found {kind:?} {shape:?}"
            ));
        }
        let value = |b: &[u8]| f32::from_le_bytes([b[0], b[1], b[2], b[3]]);
        let values: Vec<f32> = found.data().chunks_exact(4).map(value).collect();
        if values.iter().any(|v| !v.is_finite()) {
            return Err(format!("{name}: expected finite numbers"));
        }
        *param = Param::from_data(TensorData::new(values, dims), &param.device());
        Ok(())
    }
    let take_all = |network: &mut Network<B>| -> Result<(), String> {
        let stacks = [
            ("encoder", &mut network.encoder),
            ("decoder", &mut network.decoder),
        ];
        for (stack, layers) in stacks {
            for (number, layer) in layers.iter_mut().enumerate() {
                let name = |part: &str| format!("{stack}.{number}.{part}");
                take(&file, &name("weight_ih"), &mut layer.weight_ih)?;
                take(&file, &name("weight_hh"), &mut layer.weight_hh)?;
                take(&file, &name("bias_ih"), &mut layer.bias_ih)?;
                take(&file, &name("bias_hh"), &mut layer.bias_hh)?;
            }
        }
        take(&file, "dense.weight", &mut network.dense_weight)?;
        take(&file, "dense.bias", &mut network.dense_bias)
    };
    take_all(&mut network).map_err(|what| bad(&what))?;
    Ok(network)
}
