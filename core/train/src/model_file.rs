//! The model file: safetensors in PyTorch's names and gate order, with everything needed to use it and to doubt it.

use std::collections::HashMap;
use std::path::Path;

use burn::module::Param;
use burn::prelude::*;
use safetensors::tensor::{Dtype, TensorView};
use serde::Serialize;
use serde_json::json;

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
    /// Spearman's rank correlation with the ratings.
    pub spearman: f64,
    pub z_lo: f32,
    pub z_hi: f32,
}

/// Finds what drives roughness (its mean with friction, as the thesis reads z1) and hardness.
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
    let rated = |of: fn(&Rating) -> f32| -> Option<Vec<f32>> {
        let rating = |place: &Place| {
            let label = &windows.recording(*place).label;
            ratings.iter().find(|r| r.label == *label).map(of)
        };
        places.iter().map(rating).collect()
    };
    let driver = |of: fn(&Rating) -> f32| {
        let rated = rated(of)?;
        let found = (0..width).map(|coordinate| {
            let mut z: Vec<f32> = latents.iter().map(|z| z[coordinate]).collect();
            let spearman = crate::measure::spearman(&z, &rated);
            z.sort_by(f32::total_cmp);
            Driver {
                coordinate,
                sign: if spearman < 0.0 { -1 } else { 1 },
                spearman,
                z_lo: z[z.len() / 20],
                z_hi: z[z.len() - 1 - z.len() / 20],
            }
        });
        found.max_by(|a, b| a.spearman.abs().total_cmp(&b.spearman.abs()))
    };
    Latent {
        roughness: driver(|r| (r.roughness + r.friction) / 2.0),
        hardness: driver(|r| r.hardness),
    }
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

    let names = |part: &[usize]| -> Vec<&str> {
        part.iter()
            .map(|&r| windows.recordings.all[r].name.as_str())
            .collect()
    };
    let split = json!({
        "train": names(&about.split.train),
        "test": names(&about.split.test),
        "validation": names(&about.split.validation),
    });
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
