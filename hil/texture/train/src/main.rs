//! Trains the texture autoencoder of chapter 3 of the thesis, and measures what it has learnt.

mod aims;
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
mod start;
mod training;
mod whitening;
mod windows;

use std::path::PathBuf;
use std::process::ExitCode;

use clap::Parser;

use aims::corners;
use failure::Failure;
use recordings::{LabelFacts, Recordings};
use settings::Settings;
use windows::{Scale, Split, Windows};

/// Trains the texture autoencoder on a folder of recordings and writes a model file.
#[derive(Debug, Parser)]
#[command(name = "palpate-train", version)]
struct Arguments {
    /// Folder of recordings: `LABEL_NUMBER.csv` with a header, or the iCub set's `icub_N.npy`. A `ratings.csv`
    /// (label,trained,hardness,roughness,friction) or `materials.csv` beside them says which labels may be trained on.
    #[arg(value_name = "FOLDER")]
    data: PathBuf,
    /// File of the model.
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
    /// Readings per second of the recordings: the model is then refused at another rate.
    #[arg(long = "hz", value_name = "HZ")]
    rate_hz: Option<f64>,
    /// Rounds the trained weights to half precision: the file is half as large, and the errors are those of the rounded ones.
    #[arg(long)]
    half: bool,
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
    let known = LabelFacts::read(&arguments.data)?;
    let shares = <[u32; 3]>::try_from(arguments.split.as_slice())
        .map_err(|_| Failure::Usage("--split: expected three shares, as 80,15,5".into()))?;
    check(arguments, &known)?;
    let mut labels = recordings.all.iter().map(|r| &r.label);
    let is_known = |label: &&String| known.materials.iter().any(|m| m.label == **label);
    if let Some(label) = labels.find(|label| settings.heads > 0.0 && !is_known(label)) {
        let what = format!("materials.csv: expected a row for {label}, which --heads is to learn");
        return Err(Failure::file(&arguments.data, what));
    }
    let count = recordings.labels().len();
    if settings.codes > 0.0 && corners(settings.latent) < count {
        return Err(Failure::Usage(format!(
            "--codes: expected a latent vector with a corner for each of {count} labels, found {} corners: raise --latent",
            corners(settings.latent)
        )));
    }
    let seen = |label: &str| known.may_train(label);
    let split = match settings.heads > 0.0 {
        true => Split::by_label(&recordings, seen, shares, settings.seed),
        false => Split::new(&recordings, seen, shares, settings.seed),
    };
    let scale = Scale::new(&recordings, &split.train);
    let windows = Windows {
        recordings,
        scale,
        length: arguments.window,
    };
    if let Some(folder) = &arguments.checkpoint {
        std::fs::create_dir_all(folder).map_err(|e| Failure::file(folder, e))?;
    }
    report::run(arguments, &windows, &split, &known)
}

/// Checks that the settings fit together and that the folder has the tables that they need.
fn check(arguments: &Arguments, known: &LabelFacts) -> Result<(), Failure> {
    let settings = &arguments.settings;
    let [heads, aligned, coded] =
        [settings.heads, settings.align, settings.codes].map(|weight| weight > 0.0);
    let wide = if heads {
        3
    } else if aligned {
        2
    } else {
        1
    };
    let tied = [heads, aligned, coded].map(usize::from);
    let what = if settings.latent < wide || arguments.window < 2 {
        "expected a latent vector of at least 1 (2 with --align, 3 with --heads) and a window of 2"
    } else if tied.iter().sum::<usize>() > 1 {
        "expected one of --heads, --align and --codes, found more: they tie the same coordinates"
    } else if heads && known.materials.is_empty() {
        "--heads: expected a materials.csv beside the recordings, as `hil texture strokes` writes it"
    } else if !(heads || coded) && settings.along {
        "--along: expected --heads or --codes, which it asks earlier"
    } else if !(heads || coded) && settings.decode <= 0.0 {
        "--decode 0: expected --heads or --codes, or there is nothing to learn"
    } else {
        return Ok(());
    };
    Err(Failure::Usage(what.into()))
}

#[cfg(test)]
#[test]
fn the_command_line_is_sound() {
    <Arguments as clap::CommandFactory>::command().debug_assert();
}
