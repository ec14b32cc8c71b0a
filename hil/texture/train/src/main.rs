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
mod settings;
mod shown;
mod training;
mod windows;

use std::path::PathBuf;
use std::process::ExitCode;

use clap::Parser;

use failure::Failure;
use recordings::Recordings;
use settings::Settings;
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
    /// Shares of the recordings for training, test and validation, per cent.
    #[arg(long, value_delimiter = ',', default_values_t = [80, 15, 5])]
    split: Vec<u32>,
    #[command(flatten)]
    settings: Settings,
    /// Keeps a checkpoint here after every epoch, and goes on from one.
    #[arg(long, value_name = "FOLDER")]
    checkpoint: Option<PathBuf>,
    /// Stops after the epoch in which so many minutes have passed.
    #[arg(long)]
    minutes: Option<f64>,
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
    let settings = &arguments.settings;
    eprintln!("training on {}", settings.device.name()?);
    let recordings = Recordings::read(&arguments.data, &arguments.columns, &arguments.without)?;
    let ratings = recordings::ratings(&arguments.data)?;
    let shares = <[u32; 3]>::try_from(arguments.split.as_slice())
        .map_err(|_| Failure::Usage("--split: expected three shares, as 80,15,5".into()))?;
    if settings.latent < if settings.align > 0.0 { 2 } else { 1 } || arguments.window < 2 {
        return Err(Failure::Usage(
            "expected a latent vector of at least 1 (2 with --align) and a window of 2".into(),
        ));
    }
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
    report::run(arguments, &windows, &split, &ratings)
}
