//! Settings of one training run, and its progress. The same settings and recordings give the same model, on the
//! processor bit by bit.

use clap::Args;
use serde::{Deserialize, Serialize};

use crate::device::Device;

// no doc comment: the command line would print it in place of the program's own
#[derive(Args, Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Settings {
    /// Seed of split, first weights and order.
    #[arg(long, default_value_t = 1)]
    pub seed: u64,
    /// Width of the latent vector.
    #[arg(long, default_value_t = 3)]
    pub latent: usize,
    /// Windows per step; the thesis took 1.
    #[arg(long, default_value_t = 16)]
    pub batch: usize,
    /// Learning rate after warming up; the thesis took 1e-5 throughout.
    #[arg(long, default_value_t = 2e-3)]
    pub rate: f64,
    /// Learning rate at the end, where a half cosine takes it.
    #[arg(long, default_value_t = 2e-5)]
    pub last_rate: f64,
    /// Epochs over which the rate rises from nothing; the thesis had none.
    #[arg(long, default_value_t = 2)]
    pub warm_up: usize,
    /// Epochs; the thesis took 500.
    #[arg(long, default_value_t = 300)]
    pub epochs: usize,
    /// Rows from one training window to the next. Tests always take every window.
    #[arg(long, default_value_t = 1)]
    pub hop: usize,
    /// An epoch takes one in so many of the training windows, drawn anew each time; the thesis took all.
    #[arg(long, default_value_t = 4)]
    pub share: usize,
    /// Stops after so many epochs without a better validation error.
    #[arg(long, default_value_t = 40)]
    pub patience: usize,
    /// Weight of the term that ties z1 to rated roughness and friction and z2 to rated hardness.
    #[arg(long, default_value_t = 0.0)]
    pub align: f64,
    /// Weight of the term that ties z1, z2 and z3 to a surface's roughness, friction and hardness: relief, friction and
    /// stiffness of `materials.csv`, whatever the hand does.
    #[serde(default)]
    #[arg(long, default_value_t = 0.0)]
    pub heads: f64,
    /// Weight of the term that ties the latent vector to a corner of its own for each label, far from those of all others.
    #[serde(default)]
    #[arg(long, default_value_t = 0.0)]
    pub codes: f64,
    /// Asks --heads or --codes at every step of a window's later half too, not at its end alone.
    #[serde(default)]
    #[arg(long)]
    pub along: bool,
    /// Weight of the reconstruction error; at 0 the decoder keeps its first weights, which saves half of the time.
    #[serde(default = "whole")]
    #[arg(long, default_value_t = 1.0)]
    pub decode: f64,
    /// Learns from readings whose changes are equally strong in every direction. The model takes plain ones.
    #[serde(default)]
    #[arg(long)]
    pub whiten: bool,
    /// Begins with weights that hear what is fast and small.
    #[serde(default)]
    #[arg(long)]
    pub high_pass: bool,
    /// Epochs at the beginning in which encoder and decoder learn apart from each other, with principal components
    /// in the latent vector's place; the thesis had none.
    #[arg(long, default_value_t = 0)]
    pub guided: usize,
    /// Device to train on.
    // models and checkpoints from before there was a choice ran on the processor
    #[serde(default)]
    #[arg(long, value_enum, default_value_t = Device::Cpu)]
    pub device: Device,
}

/// The weight of the reconstruction error before there was a choice.
const fn whole() -> f64 {
    1.0
}

/// Progress after some epochs.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Progress {
    pub epochs: usize,
    pub best_epoch: usize,
    /// Losses of every epoch: over the training windows while it ran, over the validation windows after.
    pub train: Vec<f64>,
    pub validation: Vec<f64>,
}

impl Progress {
    /// Tells whether another epoch is due.
    pub fn goes_on(&self, settings: &Settings) -> bool {
        self.epochs < settings.epochs && self.epochs - self.best_epoch < settings.patience
    }

    /// Adds an epoch's errors. Returns whether it is the best so far.
    pub fn add(&mut self, train: f64, validation: f64) -> bool {
        self.epochs += 1;
        let best = self
            .validation
            .iter()
            .copied()
            .fold(f64::INFINITY, f64::min);
        let better = validation < best;
        if better {
            self.best_epoch = self.epochs;
        }
        self.train.push(train);
        self.validation.push(validation);
        better
    }
}
