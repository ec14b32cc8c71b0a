//! Trains the texture autoencoder of chapter 3 of the thesis, and measures what it has learnt.

mod checkpoint;
mod device;
mod failure;
mod gru;
mod guide;
mod measure;
mod model_file;
mod network;
mod recordings;
mod report;
mod training;
mod windows;

use std::path::PathBuf;
use std::process::ExitCode;

use clap::Parser;

use device::Device;
use failure::Failure;
use recordings::Recordings;
use training::Settings;
use windows::{Scale, Split, Windows};

/// Trains the texture autoencoder on a folder of recordings and writes a model file.
#[derive(Debug, Parser)]
#[command(name = "palpate-train", version)]
struct Arguments {
    /// Folder of recordings: `LABEL_NUMBER.csv` with a header, or the iCub set's `icub_N.npy`. A `ratings.csv`
    /// (label,trained,hardness,roughness,friction) beside them says which labels may be trained on.
    #[arg(value_name = "FOLDER")]
    data: PathBuf,
    /// Where the model goes.
    #[arg(long, value_name = "FILE")]
    model: PathBuf,
    /// Columns to take: those whose name begins so.
    #[arg(long, value_name = "PREFIX", default_value = "txl")]
    columns: String,
    /// Taxels to leave out, by the part of their columns' names before the underscore.
    #[arg(long, value_name = "TAXEL")]
    without: Vec<String>,
    /// Rows of a window.
    #[arg(long, default_value_t = 100)]
    window: usize,
    /// Width of the latent vector.
    #[arg(long, default_value_t = 3)]
    latent: usize,
    /// Windows a step; the thesis took 1.
    #[arg(long, default_value_t = 16)]
    batch: usize,
    /// Learning rate after warming up; the thesis took 1e-5 throughout.
    #[arg(long, default_value_t = 2e-3)]
    rate: f64,
    /// Learning rate at the end, where a half cosine takes it.
    #[arg(long, default_value_t = 2e-5)]
    last_rate: f64,
    /// Epochs over which the rate rises from nothing; the thesis had none.
    #[arg(long, default_value_t = 2)]
    warm_up: usize,
    /// Epochs; the thesis took 500.
    #[arg(long, default_value_t = 300)]
    epochs: usize,
    /// Rows from one training window to the next. Tests always take every window.
    #[arg(long, default_value_t = 1)]
    hop: usize,
    /// An epoch takes one in so many of the training windows, drawn anew each time; the thesis took all.
    #[arg(long, default_value_t = 4)]
    share: usize,
    /// Stops after so many epochs without a better validation error.
    #[arg(long, default_value_t = 40)]
    patience: usize,
    /// Weight of the term that ties z1 to rated roughness and friction and z2 to rated hardness.
    #[arg(long, default_value_t = 0.0)]
    align: f64,
    /// Epochs at the beginning in which encoder and decoder learn apart from each other, with principal components
    /// in the latent vector's place; the thesis had none.
    #[arg(long, default_value_t = 0)]
    guided: usize,
    /// Begins with the weights of this model file, trained on the same split, in place of drawn ones.
    #[arg(long, value_name = "FILE")]
    from: Option<PathBuf>,
    /// Shares of the recordings for training, test and validation, per cent.
    #[arg(long, value_delimiter = ',', default_values_t = [80, 15, 5])]
    split: Vec<u32>,
    /// Seed of split, first weights and order.
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// What to train on.
    #[arg(long, value_enum, default_value_t = Device::Cpu)]
    device: Device,
    /// Keeps a checkpoint here after every epoch, and goes on from one.
    #[arg(long, value_name = "FOLDER")]
    checkpoint: Option<PathBuf>,
    /// Stops after the epoch in which so many minutes have passed.
    #[arg(long)]
    minutes: Option<f64>,
    /// Writes what was measured as JSON.
    #[arg(long, value_name = "FILE")]
    report: Option<PathBuf>,
    /// The revision to write into the model; by default what git says.
    #[arg(long)]
    revision: Option<String>,
}

fn main() -> ExitCode {
    match run(&Arguments::parse()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => {
            eprintln!("palpate-train: {failure}");
            ExitCode::from(2)
        }
    }
}

fn run(arguments: &Arguments) -> Result<(), Failure> {
    eprintln!("training on {}", arguments.device.name()?);
    let recordings = Recordings::read(&arguments.data, &arguments.columns, &arguments.without)?;
    let ratings = recordings::ratings(&arguments.data)?;
    let shares = <[u32; 3]>::try_from(arguments.split.as_slice())
        .map_err(|_| Failure::Usage("--split: expected three shares, as 80,15,5".into()))?;
    if arguments.latent < if arguments.align > 0.0 { 2 } else { 1 } || arguments.window < 2 {
        return Err(Failure::Usage(
            "expected a latent vector of at least 1 (2 with --align) and a window of 2".into(),
        ));
    }
    let settings = Settings {
        seed: arguments.seed,
        latent: arguments.latent,
        batch: arguments.batch,
        rate: arguments.rate,
        last_rate: arguments.last_rate,
        warm_up: arguments.warm_up,
        epochs: arguments.epochs,
        hop: arguments.hop,
        share: arguments.share,
        patience: arguments.patience,
        align: arguments.align,
        guided: arguments.guided,
        from: arguments.from.clone(),
        device: arguments.device,
    };
    let seen = |label: &str| {
        ratings
            .iter()
            .find(|r| r.label == label)
            .is_none_or(|r| r.trained)
    };
    let split = Split::new(&recordings, seen, shares, settings.seed);
    let scale = Scale::new(&recordings, &split.train);
    let windows = Windows {
        recordings,
        scale,
        length: arguments.window,
    };
    if let Some(folder) = &arguments.checkpoint {
        std::fs::create_dir_all(folder).map_err(|e| Failure::file(folder, e))?;
    }
    report::run(arguments, &windows, &split, &ratings, &settings)
}
