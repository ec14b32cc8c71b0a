//! The training itself: Adam on the reconstruction error, early stop, a checkpoint after every epoch.

use std::path::{Path, PathBuf};

use burn::backend::{Autodiff, NdArray};
use burn::grad_clipping::GradientClippingConfig;
use burn::module::AutodiffModule;
use burn::optim::{AdamConfig, GradientsParams, Optimizer};
use burn::prelude::*;
use palpate_core::random::Stream;
use serde::{Deserialize, Serialize};

use crate::checkpoint;
use crate::device::{Device, Learning};
use crate::failure::Failure;
use crate::gru::Recurrent;
use crate::guide::Guide;
use crate::model_file;
use crate::network::Network;
use crate::recordings::Rating;
use crate::windows::{Place, Split, Windows, shuffle};

/// Rows between the beginnings of the windows that validation takes.
const VALIDATION_HOP: usize = 4;

/// Added to the root of Adam's second moment: Keras's, and with it the thesis's. The framework's own is 1e-5.
const EPSILON: f32 = 1e-7;

/// Where trained networks are measured, whatever they were trained on: it is what the engine of `core` agrees with.
pub type Plain = NdArray;

/// What one training run is. The same settings and recordings give the same model, on the processor bit by bit.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Settings {
    pub seed: u64,
    pub latent: usize,
    pub batch: usize,
    /// Learning rate after warming up; from there it falls along a half cosine to `last_rate` at the end.
    pub rate: f64,
    pub last_rate: f64,
    /// Epochs over which the rate rises from nothing.
    pub warm_up: usize,
    pub epochs: usize,
    /// Rows between the beginnings of training windows. Testing always uses every window.
    pub hop: usize,
    /// An epoch takes one in so many of the training windows, drawn anew each time: neighbours are near duplicates.
    pub share: usize,
    /// Epochs without a better validation error after which training stops.
    pub patience: usize,
    /// Weight of the term that ties z1 to rated roughness and friction and z2 to rated hardness; 0: none.
    pub align: f64,
    /// Epochs at the beginning in which encoder and decoder learn apart, principal components between them.
    pub guided: usize,
    /// The model file whose weights it begins with; none: drawn ones.
    pub from: Option<PathBuf>,
    /// What it runs on; models and checkpoints from before there was a choice ran on the processor.
    #[serde(default)]
    pub device: Device,
}

/// What has been reached after some epochs.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Progress {
    pub epochs: usize,
    pub best_epoch: usize,
    /// Mean squared errors of every epoch: over the training windows while it ran, over the validation windows after.
    pub train: Vec<f64>,
    pub validation: Vec<f64>,
}

impl Progress {
    fn best(&self) -> f64 {
        self.validation
            .iter()
            .copied()
            .fold(f64::INFINITY, f64::min)
    }
}

/// Trains, from the checkpoint in `folder` if there is one for these settings. `report` hears of every epoch and
/// says whether to go on.
pub fn train(
    windows: &Windows,
    split: &Split,
    ratings: &[Rating],
    settings: &Settings,
    folder: Option<&Path>,
    report: impl FnMut(&Progress) -> bool,
) -> Result<(Network<Plain>, Progress), Failure> {
    match settings.device {
        Device::Cpu => {
            train_on::<Autodiff<NdArray>>(windows, split, ratings, settings, folder, report)
        }
        #[cfg(feature = "gpu")]
        Device::Gpu => {
            train_on::<Autodiff<burn_wgpu::Wgpu>>(windows, split, ratings, settings, folder, report)
        }
        #[cfg(not(feature = "gpu"))]
        Device::Gpu => Err(Device::not_built()),
    }
}

fn train_on<L: Learning>(
    windows: &Windows,
    split: &Split,
    ratings: &[Rating],
    settings: &Settings,
    folder: Option<&Path>,
    mut report: impl FnMut(&Progress) -> bool,
) -> Result<(Network<Plain>, Progress), Failure> {
    let device = Default::default();
    let features = windows.recordings.columns.len();
    let mut network = Network::<L>::new(
        features,
        settings.latent,
        windows.length,
        settings.seed,
        &device,
    );
    if let Some(from) = &settings.from {
        network = model_file::weights(from, network, windows, split)?;
    }
    let adam = AdamConfig::new().with_epsilon(EPSILON);
    let mut adam = adam.init::<L, Network<L>>();
    adam = adam.with_grad_clipping(GradientClippingConfig::Norm(1.0).init());
    let mut progress = Progress::default();
    let mut best = network.valid();
    let path: Option<PathBuf> = folder.map(|folder| folder.join("checkpoint.safetensors"));
    if let Some(path) = path.as_deref().filter(|path| path.exists()) {
        (network, adam, best, progress) =
            checkpoint::read(path, settings, network, adam, best, &device)?;
    }
    let places = windows.of(&split.train, settings.hop);
    let validation = windows.of(&split.validation, VALIDATION_HOP);
    if places.is_empty() || validation.is_empty() {
        return Err(Failure::Usage(format!(
            "no window of {} rows in the training or validation recordings: shorten --window or change --split",
            windows.length
        )));
    }
    let guide = Guide::new(windows, &split.train, settings.latent);
    while progress.epochs < settings.epochs
        && progress.epochs - progress.best_epoch < settings.patience
    {
        let mut order = places.clone();
        shuffle(
            &mut order,
            &mut Stream::new(settings.seed, &format!("epoch {}", progress.epochs)),
        );
        order.truncate(places.len().div_ceil(settings.share.max(1)));
        let batches = order.chunks(settings.batch.max(1));
        let steps = batches.len() as f64;
        let mut sum = 0.0;
        for (step, batch) in batches.enumerate() {
            let rate = rate(settings, progress.epochs as f64 + (step + 1) as f64 / steps);
            let x = windows.batch::<L>(batch, &device);
            let z = network.encode(x.clone());
            let error = if progress.epochs < settings.guided {
                let wanted = guide.latents(windows, batch, &device);
                let miss = guide.miss(z.clone(), wanted.clone());
                difference(network.decode(wanted, windows.length), x) + miss
            } else {
                difference(network.decode(z.clone(), windows.length), x)
            };
            sum += f64::from(error.clone().into_scalar().elem::<f32>()) * batch.len() as f64;
            let loss = match targets(windows, batch, ratings) {
                Some(targets) if settings.align > 0.0 => error + tie(z, targets) * settings.align,
                _ => error,
            };
            let gradients = GradientsParams::from_grads(loss.backward(), &network);
            network = adam.step(rate, network, gradients);
        }
        let now = network.valid();
        let error = reconstruction(&now, windows, &validation);
        progress.epochs += 1;
        if error < progress.best() {
            progress.best_epoch = progress.epochs;
            best = now;
        }
        progress.train.push(sum / order.len() as f64);
        progress.validation.push(error);
        if let Some(path) = &path {
            checkpoint::write(path, settings, &network, &adam, &best, &progress)?;
        }
        if !report(&progress) {
            break;
        }
    }
    Ok((best.carried(&Default::default()), progress))
}

/// Learning rate after so many epochs, whole and begun.
fn rate(settings: &Settings, epochs: f64) -> f64 {
    let warm_up = settings.warm_up as f64;
    if epochs < warm_up {
        return settings.rate * epochs / warm_up;
    }
    let share = (epochs - warm_up) / (settings.epochs as f64 - warm_up).max(1.0);
    let fall = 0.5 + 0.5 * (core::f64::consts::PI * share.min(1.0)).cos();
    settings.last_rate + (settings.rate - settings.last_rate) * fall
}

/// Mean square of a difference.
fn difference<B: Backend>(a: Tensor<B, 3>, b: Tensor<B, 3>) -> Tensor<B, 1> {
    (a - b).powi_scalar(2).mean()
}

/// Mean squared error over windows.
pub fn reconstruction<B: Recurrent>(
    network: &Network<B>,
    windows: &Windows,
    places: &[Place],
) -> f64 {
    let device = B::Device::default();
    let mut sum = 0.0;
    for some in places.chunks(256) {
        let x = windows.batch::<B>(some, &device);
        let error = difference(network.decode(network.encode(x.clone()), windows.length), x);
        sum += f64::from(error.into_scalar().elem::<f32>()) * some.len() as f64;
    }
    sum / places.len().max(1) as f64
}

/// Latent vectors of windows, one after another.
pub fn latents<B: Recurrent>(
    network: &Network<B>,
    windows: &Windows,
    places: &[Place],
) -> Vec<Vec<f32>> {
    let device = B::Device::default();
    let mut all = Vec::with_capacity(places.len());
    for some in places.chunks(256) {
        let z = network.encode(windows.batch::<B>(some, &device));
        let [_, width] = z.dims();
        let values: Vec<f32> = z.into_data().into_vec().expect("training is in f32");
        all.extend(values.chunks_exact(width).map(<[f32]>::to_vec));
    }
    all
}

/// Where the ratings put z1 and z2 of each window: 1 to 6 on -0.75 to 0.75, inside what a GRU can say.
fn targets(windows: &Windows, batch: &[Place], ratings: &[Rating]) -> Option<Vec<f32>> {
    let on = |rating: f32| (rating - 3.5) * 0.3;
    let mut targets = Vec::with_capacity(2 * batch.len());
    for &place in batch {
        let label = &windows.recording(place).label;
        let rating = ratings.iter().find(|r| r.label == *label)?;
        targets.extend([
            on((rating.roughness + rating.friction) / 2.0),
            on(rating.hardness),
        ]);
    }
    Some(targets)
}

fn tie<B: Backend>(z: Tensor<B, 2>, targets: Vec<f32>) -> Tensor<B, 1> {
    let [batch, _] = z.dims();
    let targets = Tensor::<B, 2>::from_data(TensorData::new(targets, [batch, 2]), &z.device());
    (z.slice([0..batch, 0..2]) - targets).powi_scalar(2).mean()
}

#[cfg(test)]
#[path = "training_tests.rs"]
pub mod tests;
