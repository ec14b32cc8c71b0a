//! The model file: safetensors in PyTorch's names and gate order, with everything needed to use it and to doubt it.

use std::path::Path;

use palpate_emulators::sensor::surface::spearman;
use palpate_files::Precision;
use serde::Serialize;
use serde_json::{Value, json};

use crate::failure::{self, Failure};
use crate::network::Network;
use crate::recordings::{LabelFacts, Material, Rating};
use crate::settings::{Progress, Settings};
use crate::training::{MATERIALS_HOP, Plain, latents};
use crate::windows::{Place, Split, Windows};

/// Facts in a model file besides its weights.
pub struct About<'a> {
    pub windows: &'a Windows,
    pub split: &'a Split,
    pub settings: &'a Settings,
    pub progress: &'a Progress,
    /// Mean squared error over every window of the test recordings, where the decoder has learned.
    pub test_error: Option<f64>,
    pub latent: Latent,
    /// Readings per second of the recordings, where the command line gives them.
    pub rate_hz: Option<f64>,
    /// The command line that made it.
    pub command: String,
    pub revision: String,
    pub precision: Precision,
}

/// Latent coordinates and their properties, by rank correlation over the training recordings.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Latent {
    /// Driver of sigma and f_PWM, and of mu where no coordinate stands for friction.
    pub roughness: Option<Driver>,
    pub hardness: Option<Driver>,
    /// Friction, in a training by materials alone.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub friction: Option<Driver>,
    /// z1 against rated roughness and friction, whatever it has learned: the driver of the thesis.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub first: Option<Driver>,
}

/// A latent coordinate, its direction, and its range (5th to 95th percentile of the training windows).
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Driver {
    pub coordinate: usize,
    pub sign: i32,
    /// Source of the choice: [`RATINGS`], [`BUZZ`] or [`MATERIALS`].
    pub with: &'static str,
    /// Spearman's rank correlation with that.
    pub spearman: f64,
    pub z_lo: f32,
    pub z_hi: f32,
    /// Smallest and largest of the property over the materials of the training: um, N/mm, or a coefficient.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub learned: Option<[f64; 2]>,
}

/// Ratings of the labels by people.
const RATINGS: &str = "ratings";
/// Change of the readings from row to row, by which rough surfaces are known: for recordings without ratings.
const BUZZ: &str = "buzz";
/// Properties of the surfaces, to which the training tied the coordinate.
const MATERIALS: &str = "materials";

/// Finds the drivers of roughness (its mean with friction, as the thesis reads z1; the buzz where there are no ratings)
/// and hardness. With `heads` the training has tied z1, z2 and z3 to roughness, friction and hardness.
pub fn drivers(
    network: &Network<Plain>,
    windows: &Windows,
    train: &[usize],
    (known, heads): (&LabelFacts, bool),
) -> Latent {
    let places = windows.places(train, if heads { MATERIALS_HOP } else { 4 });
    let latents = latents(network, windows, &places);
    let Some(width) = latents.first().map(Vec::len) else {
        return Latent::default();
    };
    let driver = |coordinate: usize, with: &'static str, truth: &[f64]| {
        let mut z: Vec<f64> = latents.iter().map(|z| f64::from(z[coordinate])).collect();
        let spearman = spearman(&z, truth);
        z.sort_by(f64::total_cmp);
        Driver {
            coordinate,
            sign: if spearman < 0.0 { -1 } else { 1 },
            with,
            spearman,
            z_lo: z[z.len() / 20] as f32,
            z_hi: z[z.len() - 1 - z.len() / 20] as f32,
            learned: None,
        }
    };
    let labels = || places.iter().map(|&p| &windows.recording(p).label);
    if heads {
        let tied = |coordinate: usize| {
            let of = Material::PROPERTIES[coordinate];
            let material = |label: &String| known.materials.iter().find(|m| m.label == *label);
            let truth: Option<Vec<f64>> = labels().map(|l| material(l).map(of)).collect();
            Some(Driver {
                learned: Some(Material::range(&known.materials, of)),
                ..driver(coordinate, MATERIALS, &truth?)
            })
        };
        return Latent {
            roughness: tied(0),
            friction: tied(1),
            hardness: tied(2),
            first: None,
        };
    }
    let rated = |of: fn(&Rating) -> f32| -> Option<Vec<f64>> {
        let rating = |label: &String| known.ratings.iter().find(|r| r.label == *label);
        labels()
            .map(|l| rating(l).map(|r| f64::from(of(r))))
            .collect()
    };
    let best = |(with, truth): (&'static str, Vec<f64>)| {
        let found = (0..width).map(|coordinate| driver(coordinate, with, &truth));
        found.max_by(|a, b| a.spearman.abs().total_cmp(&b.spearman.abs()))
    };
    let roughness = rated(|r| (r.roughness + r.friction) / 2.0);
    let first = roughness.as_ref().map(|rated| driver(0, RATINGS, rated));
    let roughness = roughness.map(|rated| (RATINGS, rated));
    let buzz = || (BUZZ, places.iter().map(|&p| buzz(windows, p)).collect());
    Latent {
        roughness: best(roughness.unwrap_or_else(buzz)),
        hardness: rated(|r| r.hardness).and_then(|rated| best((RATINGS, rated))),
        friction: None,
        first,
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
    let windows = about.windows;
    let features = windows.recordings.columns.len();
    let mut tensors = network.tensors(about.settings.decode > 0.0);
    let mut add = |name: &str, shape: Vec<usize>, values: Vec<f32>| {
        tensors.push((name.to_owned(), shape, values));
    };
    add("scale.min", vec![features], windows.scale.min.clone());
    add("scale.max", vec![features], windows.scale.max.clone());
    // The golden vector: the first window of the first test recording.
    let golden = windows.places(&about.split.test, 1).first().copied();
    let golden = golden
        .ok_or_else(|| Failure::Usage("no test recording to take a golden vector from".into()))?;
    let latent = latents(network, windows, &[golden]).swap_remove(0);
    add("golden.latent", vec![latent.len()], latent);
    let window = windows.raw(golden).to_vec();
    add("golden.window", vec![windows.length, features], window);

    let progress = about.progress;
    let at = |errors: &[f64]| errors.get(progress.best_epoch.saturating_sub(1)).copied();
    let losses = json!({
        "epochs": progress.epochs,
        "best_epoch": progress.best_epoch,
        "train": at(&progress.train),
        "validation": at(&progress.validation),
        "test": about.test_error,
    });
    let mut metadata = vec![
        ("features", json!(windows.recordings.columns).to_string()),
        ("window", windows.length.to_string()),
        ("seed", about.settings.seed.to_string()),
        ("settings", json!(about.settings).to_string()),
        ("split", parts(windows, about.split).to_string()),
        ("losses", losses.to_string()),
        ("latent", json!(about.latent).to_string()),
        ("command", about.command.clone()),
        ("revision", about.revision.clone()),
    ];
    metadata.extend(about.rate_hz.map(|hz| ("rate_hz", hz.to_string())));
    let tensors: Vec<_> = tensors
        .iter()
        .map(|(name, shape, values)| (name.clone(), shape.clone(), values))
        .collect();
    let bytes = palpate_files::model_file(&tensors, &metadata, about.precision);
    failure::write(
        path,
        &bytes.expect("every tensor has the numbers of its shape"),
    )
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
