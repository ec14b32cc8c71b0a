//! The training itself: Adam on the reconstruction error, early stop, a checkpoint after every epoch.

use std::path::Path;

use burn::backend::{Autodiff, NdArray};
use burn::grad_clipping::GradientClippingConfig;
use burn::module::AutodiffModule;
use burn::optim::{AdamConfig, GradientsParams, Optimizer};
use burn::prelude::*;
use palpate_core::random::RandomStream;

use crate::checkpoint::{State, carried};
use crate::device::Device;
use crate::failure::Failure;
use crate::gru::{Learning, Recurrent};
use crate::guide::Guide;
use crate::network::Network;
use crate::recordings::Rating;
use crate::settings::{Progress, Settings};
use crate::windows::{Place, Split, Windows, shuffle};

/// Rows between the beginnings of the windows that validation takes.
const VALIDATION_HOP: usize = 4;

/// Added to the root of Adam's second moment: Keras's, and with it the thesis's. The framework's own is 1e-5.
const EPSILON: f32 = 1e-7;

/// Where trained networks are measured, whatever they were trained on: it is what the engine of `core` agrees with.
pub type Plain = NdArray;

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
    let (latent, length, seed) = (settings.latent, windows.length, settings.seed);
    let network = Network::<L>::new(features, latent, length, seed, &device);
    let adam = AdamConfig::new().with_epsilon(EPSILON);
    let adam = adam.init::<L, Network<L>>();
    let mut state = State {
        best: network.valid(),
        network,
        adam: adam.with_grad_clipping(GradientClippingConfig::Norm(1.0).init()),
        progress: Progress::default(),
    };
    let path = folder.map(|folder| folder.join("checkpoint.safetensors"));
    if let Some(path) = path.as_deref().filter(|path| path.exists()) {
        state = state.read(path, settings, &device)?;
    }
    let places = windows.of(&split.train, settings.hop);
    let validation = windows.of(&split.validation, VALIDATION_HOP);
    if places.is_empty() || validation.is_empty() {
        return Err(Failure::Usage(format!(
            "no window of {} rows in the training or validation recordings: shorten --window or change --split",
            windows.length
        )));
    }
    let lesson = Lesson::<L> {
        windows,
        ratings,
        settings,
        guide: Guide::new(windows, &split.train, latent),
        device,
    };
    while state.progress.goes_on(settings) {
        let error = lesson.epoch(&mut state, &places);
        let now = state.network.valid();
        if (state.progress).add(error, reconstruction(&now, windows, &validation)) {
            state.best = now;
        }
        if let Some(path) = &path {
            state.write(path, settings)?;
        }
        if !report(&state.progress) {
            break;
        }
    }
    let plain = Network::<Plain>::new(features, latent, length, seed, &Default::default());
    Ok((carried(state.best, plain)?, state.progress))
}

/// What stays from epoch to epoch.
struct Lesson<'a, L: Learning> {
    windows: &'a Windows,
    ratings: &'a [Rating],
    settings: &'a Settings,
    guide: Guide,
    device: L::Device,
}

impl<L: Learning> Lesson<'_, L> {
    /// One epoch over its share of the training windows; their mean squared error while it ran.
    fn epoch<O: Optimizer<Network<L>, L>>(&self, state: &mut State<L, O>, places: &[Place]) -> f64 {
        let (settings, epochs) = (self.settings, state.progress.epochs);
        let mut order = places.to_vec();
        let mut draw = RandomStream::new(settings.seed, &format!("epoch {epochs}"));
        shuffle(&mut order, &mut draw);
        order.truncate(places.len().div_ceil(settings.share.max(1)));
        let batches = order.chunks(settings.batch.max(1));
        let steps = batches.len() as f64;
        let mut sum = 0.0;
        for (step, batch) in batches.enumerate() {
            let rate = rate(settings, epochs as f64 + (step + 1) as f64 / steps);
            let (error, loss) = self.loss(&state.network, batch, epochs < settings.guided);
            sum += f64::from(error.into_scalar().elem::<f32>()) * batch.len() as f64;
            let gradients = GradientsParams::from_grads(loss.backward(), &state.network);
            state.network = state.adam.step(rate, state.network.clone(), gradients);
        }
        sum / order.len() as f64
    }

    /// The mean squared error over a batch, and what is to fall: with the tie to the ratings, if there is one.
    fn loss(
        &self,
        network: &Network<L>,
        batch: &[Place],
        guided: bool,
    ) -> (Tensor<L, 1>, Tensor<L, 1>) {
        let (windows, guide) = (self.windows, &self.guide);
        let x = windows.batch::<L>(batch, &self.device);
        let z = network.encode(x.clone());
        let error = if guided {
            let wanted = guide.latents(windows, batch, &self.device);
            let miss = guide.miss(z.clone(), wanted.clone());
            difference(network.decode(wanted, windows.length), x) + miss
        } else {
            difference(network.decode(z.clone(), windows.length), x)
        };
        let loss = match targets(windows, batch, self.ratings) {
            Some(targets) if self.settings.align > 0.0 => {
                error.clone() + tie(z, targets) * self.settings.align
            }
            _ => error.clone(),
        };
        (error, loss)
    }
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
