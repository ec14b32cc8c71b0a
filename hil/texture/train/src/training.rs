//! The training itself: Adam on the reconstruction error, early stop, a checkpoint after every epoch.

use std::path::Path;

use burn::backend::{Autodiff, NdArray};
use burn::grad_clipping::GradientClippingConfig;
use burn::module::AutodiffModule;
use burn::optim::{AdamConfig, GradientsParams, Optimizer};
use burn::prelude::*;
use burn::record::{FullPrecisionSettings, HalfPrecisionSettings};
use palpate_core::random::RandomStream;

use crate::aims::Aims;
use crate::checkpoint::{State, carried};
use crate::device::Device;
use crate::failure::Failure;
use crate::gru::{Learning, Recurrent};
use crate::guide::Guide;
use crate::network::{Network, last};
use crate::recordings::LabelFacts;
use crate::settings::{Progress, Settings};
use crate::whitening::Whitening;
use crate::windows::{Place, Split, Windows, shuffle};

/// Rows between the beginnings of the windows that validation takes.
const VALIDATION_HOP: usize = 4;
/// Rows between validation windows over hundreds of materials, each of which says little more with every window.
pub const MATERIALS_HOP: usize = 20;

/// Constant added to the root of Adam's second moment: Keras's, and with it the thesis's. The framework's own is 1e-5.
const EPSILON: f32 = 1e-7;

/// Backend on which trained networks are measured, whatever they were trained on: the engine of `core` agrees with it.
pub type Plain = NdArray;

/// Trains, from the checkpoint in `folder` if there is one for these settings. `report` hears of every epoch and
/// returns whether to go on.
pub fn train(
    plain: &Windows,
    split: &Split,
    known: &LabelFacts,
    settings: &Settings,
    folder: Option<&Path>,
    report: impl FnMut(&Progress) -> bool,
) -> Result<(Network<Plain>, Progress), Failure> {
    let whitening = settings.whiten.then(|| Whitening::new(plain, &split.train));
    let whitened = whitening.as_ref().map(|w| w.whitened(plain));
    let windows = whitened.as_ref().unwrap_or(plain);
    let (network, progress) = match settings.device {
        Device::Cpu => {
            train_on::<Autodiff<NdArray>>(windows, split, known, settings, folder, report)
        }
        #[cfg(feature = "gpu")]
        Device::Gpu => {
            train_on::<Autodiff<burn_wgpu::Wgpu>>(windows, split, known, settings, folder, report)
        }
        #[cfg(not(feature = "gpu"))]
        Device::Gpu => Err(Device::not_built()),
    }?;
    let folded = match whitening {
        Some(whitening) => whitening.folded(network),
        None => network,
    };
    Ok((folded, progress))
}

fn train_on<L: Learning>(
    windows: &Windows,
    split: &Split,
    known: &LabelFacts,
    settings: &Settings,
    folder: Option<&Path>,
    mut report: impl FnMut(&Progress) -> bool,
) -> Result<(Network<Plain>, Progress), Failure> {
    let device = Default::default();
    let mut network = blank::<L>(windows, settings);
    if settings.high_pass {
        network.hear_what_is_fast(settings.seed);
    }
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
    let places = windows.places(&split.train, settings.hop);
    let is_tied = settings.heads > 0.0 || settings.codes > 0.0;
    let hop = if settings.heads > 0.0 {
        MATERIALS_HOP
    } else {
        VALIDATION_HOP
    };
    let validation = windows.places(&split.validation, hop);
    if places.is_empty() || validation.is_empty() {
        return Err(Failure::Usage(format!(
            "no window of {} rows in the training or validation recordings: shorten --window or change --split",
            windows.length
        )));
    }
    let lesson = Lesson::<L> {
        windows,
        aims: Aims::new(known, &windows.recordings.labels(), settings),
        settings,
        guide: (settings.guided > 0).then(|| Guide::new(windows, &split.train, settings.latent)),
        device,
    };
    while state.progress.goes_on(settings) {
        let error = lesson.epoch(&mut state, &places);
        let now = state.network.valid();
        // with ratings alone the reconstruction judges, as it always did
        let judged = match is_tied {
            true => lesson.judged(&now, &validation),
            false => reconstruction(&now, windows, &validation),
        };
        if (state.progress).add(error, judged) {
            state.best = now;
        }
        if let Some(path) = &path {
            state.write(path, settings)?;
        }
        if !report(&state.progress) {
            break;
        }
    }
    let best = carried::<_, _, FullPrecisionSettings>(state.best, blank(windows, settings))?;
    Ok((best, state.progress))
}

/// A network whose weights are numbers of half precision, each the nearest.
///
/// # Errors
/// A network that the framework cannot pack.
pub fn halved(
    network: Network<Plain>,
    windows: &Windows,
    settings: &Settings,
) -> Result<Network<Plain>, Failure> {
    carried::<_, _, HalfPrecisionSettings>(network, blank(windows, settings))
}

/// A network that has learned nothing.
fn blank<B: Backend>(windows: &Windows, settings: &Settings) -> Network<B> {
    let features = windows.recordings.columns.len();
    let (latent, seed) = (settings.latent, settings.seed);
    Network::new(features, latent, windows.length, seed, &Default::default())
}

/// Parameters that stay from epoch to epoch.
struct Lesson<'a, L: Learning> {
    windows: &'a Windows,
    aims: Option<Aims>,
    settings: &'a Settings,
    guide: Option<Guide>,
    device: L::Device,
}

impl<L: Learning> Lesson<'_, L> {
    /// Runs one epoch over its share of the training windows. Returns the mean loss while it ran.
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
            let x = self.windows.batch::<L>(batch, &self.device);
            let loss = match &self.guide {
                Some(guide) if epochs < settings.guided => {
                    self.guided((&state.network, guide), x, batch)
                }
                _ => self.loss(&state.network, x, batch),
            };
            sum += f64::from(loss.clone().into_scalar().elem::<f32>()) * batch.len() as f64;
            let gradients = GradientsParams::from_grads(loss.backward(), &state.network);
            state.network = state.adam.step(rate, state.network.clone(), gradients);
        }
        sum / order.len() as f64
    }

    /// Loss over a batch: the weighted reconstruction error, and the miss of the aims of its labels.
    fn loss<B: Recurrent>(
        &self,
        network: &Network<B>,
        x: Tensor<B, 3>,
        batch: &[Place],
    ) -> Tensor<B, 1> {
        let states = network.states(x.clone());
        let miss = match self.settings.along {
            true => (self.aims.as_ref()).and_then(|a| a.miss_along(&states, self.windows, batch)),
            false => self.miss(&last(states.clone()), batch),
        };
        let z = last(states);
        let weight = self.settings.decode;
        let error = (weight > 0.0)
            .then(|| difference(network.decode(z.clone(), self.windows.length), x) * weight);
        match (error, miss) {
            (Some(error), Some(miss)) => error + miss,
            (Some(loss), None) | (None, Some(loss)) => loss,
            // nothing is to fall
            (None, None) => z.sum() * 0.0,
        }
    }

    /// Loss over a batch while encoder and decoder learn apart from each other.
    fn guided(
        &self,
        (network, guide): (&Network<L>, &Guide),
        x: Tensor<L, 3>,
        batch: &[Place],
    ) -> Tensor<L, 1> {
        let z = network.encode(x.clone());
        let wanted = guide.latents(self.windows, batch, &self.device);
        let apart = guide.miss(z.clone(), wanted.clone());
        let error = difference(network.decode(wanted, self.windows.length), x) + apart;
        match self.miss(&z, batch) {
            Some(miss) => error + miss,
            None => error,
        }
    }

    fn miss<B: Backend>(&self, z: &Tensor<B, 2>, batch: &[Place]) -> Option<Tensor<B, 1>> {
        self.aims.as_ref()?.miss(z, self.windows, batch)
    }

    /// Mean loss over windows.
    fn judged<B: Recurrent>(&self, network: &Network<B>, places: &[Place]) -> f64 {
        mean(self.windows, places, |x, some| self.loss(network, x, some))
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

/// Mean of a loss over windows, some of them at a time.
fn mean<B: Backend>(
    windows: &Windows,
    places: &[Place],
    loss: impl Fn(Tensor<B, 3>, &[Place]) -> Tensor<B, 1>,
) -> f64 {
    let mut sum = 0.0;
    for some in places.chunks(256) {
        let x = windows.batch::<B>(some, &B::Device::default());
        sum += f64::from(loss(x, some).into_scalar().elem::<f32>()) * some.len() as f64;
    }
    sum / places.len().max(1) as f64
}

/// Mean squared error over windows.
pub fn reconstruction<B: Recurrent>(
    network: &Network<B>,
    windows: &Windows,
    places: &[Place],
) -> f64 {
    mean(windows, places, |x, _| {
        difference(network.decode(network.encode(x.clone()), windows.length), x)
    })
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

#[cfg(test)]
#[path = "training_tests.rs"]
pub mod tests;
