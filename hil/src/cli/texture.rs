//! Options of `hil texture`.

use std::path::PathBuf;

use clap::{Args, Subcommand};

use super::{positive, rate};

/// Actions on the texture model.
#[derive(Debug, Subcommand)]
pub enum TextureAction {
    /// Record strokes over emulated textures, to train on.
    Strokes(StrokesArgs),
    /// Train a model: run the training program, or print how to build it.
    #[command(disable_help_flag = true)]
    Train(TrainArgs),
    /// Print the latent vectors of a recording as CSV: one line per window, named by its last row.
    Encode(EncodeArgs),
    /// Rebuild emulated strokes from their latent vectors, and print the error of each part of the training.
    Rebuild(RebuildArgs),
    /// Write the encoder as an ONNX model: raw counts in, latent vectors out, scaling inside.
    Export(ExportArgs),
    /// Map emulated textures in a model's latent space, with correlations to roughness, friction and
    /// hardness.
    Map(MapArgs),
    /// Vary one property of an emulated surface at a time, and print what a model's coordinates make of each.
    Response(ResponseArgs),
    /// Draw emulated materials whose properties are independent, as a table of textures.
    Materials(MaterialsArgs),
    /// Let a simulated panel rate textures, with the bare finger and on the emulated display.
    Panel(PanelArgs),
}

/// Emulated strokes.
#[derive(Debug, Args)]
pub struct Strokes {
    /// A table of textures, by name or file.
    #[arg(long, value_name = "NAME|FILE", default_value = "thesis")]
    pub textures: String,
    /// Strokes over each texture.
    #[arg(long, value_name = "N", default_value_t = 20, value_parser = super::whole::<u32, 1, 1000>, allow_hyphen_values = true)]
    pub strokes: u32,
}

/// Options of `hil texture strokes`.
#[derive(Debug, Args)]
pub struct StrokesArgs {
    /// Folder to write to.
    #[arg(short = 'o', long, value_name = "DIR")]
    pub out: PathBuf,
    /// Overwrite existing files even if hil did not write them.
    #[arg(short = 'f', long)]
    pub force: bool,
    /// Surfaces that are stroked.
    #[command(flatten)]
    pub of: Strokes,
    /// Draw force, speed, tilt and direction of every stroke widely and independently, in place of one person's habits.
    #[arg(long)]
    pub varied: bool,
    /// Readings per second; boards on CAN send 100.
    #[arg(long, value_name = "HZ", default_value_t = 100, value_parser = super::whole::<u32, 50, 1000>, allow_hyphen_values = true)]
    pub rate: u32,
    /// Give the finger an accelerometer of 3 kHz; its readings go to DIR/accelerometer, in milli-g.
    #[arg(long)]
    pub accelerometer: bool,
    /// Seed of all randomness.
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = super::whole::<u64, 0, { u64::MAX }>, allow_hyphen_values = true)]
    pub seed: u64,
}

/// Options of `hil texture train`.
#[derive(Debug, Args)]
pub struct TrainArgs {
    /// Options of the training program; `--help` lists them.
    #[arg(
        trailing_var_arg = true,
        allow_hyphen_values = true,
        value_name = "OPTION"
    )]
    pub arguments: Vec<std::ffi::OsString>,
}

/// Options of `hil texture map`.
#[derive(Debug, Args)]
pub struct MapArgs {
    /// `default`, `thesis` or a model file (.safetensors).
    #[arg(value_name = "MODEL", default_value = "default")]
    pub model: String,
    /// Surfaces that are stroked.
    #[command(flatten)]
    pub of: Strokes,
    /// Seed of the strokes; the default model was trained on those of seed 1.
    #[arg(long, value_name = "N", default_value_t = 2, value_parser = super::whole::<u64, 0, { u64::MAX }>, allow_hyphen_values = true)]
    pub seed: u64,
    /// Draw the map into this file (.svg).
    #[arg(long, value_name = "FILE")]
    pub svg: Option<PathBuf>,
    /// Overwrite existing files even if hil did not write them.
    #[arg(short = 'f', long)]
    pub force: bool,
}

/// Options of `hil texture rebuild`.
#[derive(Debug, Args)]
pub struct RebuildArgs {
    /// A model with a decoder: `thesis` or a model file (.safetensors).
    #[arg(value_name = "MODEL", default_value = "thesis")]
    pub model: String,
    /// Surfaces that are stroked.
    #[command(flatten)]
    pub of: Strokes,
    /// Seed of the strokes; `thesis` was trained on those of seed 1.
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = super::whole::<u64, 0, { u64::MAX }>, allow_hyphen_values = true)]
    pub seed: u64,
    /// Print JSON in place of a table.
    #[arg(long)]
    pub json: bool,
}

/// Options of `hil texture response`.
#[derive(Debug, Args)]
pub struct ResponseArgs {
    /// `default`, `thesis` or a model file (.safetensors).
    #[arg(value_name = "MODEL", default_value = "default")]
    pub model: String,
    /// Strokes over each surface.
    #[arg(long, value_name = "N", default_value_t = 6, value_parser = super::whole::<u32, 1, 1000>, allow_hyphen_values = true)]
    pub strokes: u32,
    /// Materials with independent properties, for partial correlations; 0: none.
    #[arg(long, value_name = "N", default_value_t = 500, value_parser = super::whole::<u32, 0, 9999>, allow_hyphen_values = true)]
    pub materials: u32,
    /// Seed of the strokes and the materials; `default` was trained on strokes of seed 1.
    #[arg(long, value_name = "N", default_value_t = 2, value_parser = super::whole::<u64, 0, { u64::MAX }>, allow_hyphen_values = true)]
    pub seed: u64,
    /// Repeat the probes with seeds 1 to N, and print the median and the range of each crosstalk.
    #[arg(long, value_name = "N", conflicts_with_all = ["seed", "materials"], value_parser = super::whole::<u64, 2, 1000>, allow_hyphen_values = true)]
    pub seeds: Option<u64>,
    /// Print JSON in place of tables.
    #[arg(long)]
    pub json: bool,
}

/// Options of `hil texture materials`.
#[derive(Debug, Args)]
pub struct MaterialsArgs {
    /// The table to write (.toml).
    #[arg(short = 'o', long, value_name = "FILE")]
    pub out: PathBuf,
    /// Number of materials.
    #[arg(long, value_name = "N", default_value_t = 350, value_parser = super::whole::<u32, 1, 9999>, allow_hyphen_values = true)]
    pub count: u32,
    /// Number of those that are not to be trained on, the last ones.
    #[arg(long, value_name = "N", default_value_t = 50, value_parser = super::whole::<u32, 0, 9999>, allow_hyphen_values = true)]
    pub unseen: u32,
    /// Seed of their properties.
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = super::whole::<u64, 0, { u64::MAX }>, allow_hyphen_values = true)]
    pub seed: u64,
    /// Overwrite an existing file even if hil did not write it.
    #[arg(short = 'f', long)]
    pub force: bool,
}

/// Options of `hil texture panel`.
#[derive(Debug, Args)]
pub struct PanelArgs {
    /// `default`, `thesis` or a model file (.safetensors).
    #[arg(value_name = "MODEL", default_value = "default")]
    pub model: String,
    /// A table of textures, by name or file.
    #[arg(long, value_name = "NAME|FILE", default_value = "thesis")]
    pub textures: String,
    /// Recordings in place of emulated strokes: a folder of NAME_NUMBER.csv, columns as for `encode`.
    #[arg(
        long,
        value_name = "DIR",
        requires = "rate",
        conflicts_with = "textures"
    )]
    pub recordings: Option<PathBuf>,
    /// Rows per second of the recordings.
    #[arg(long, value_name = "HZ", value_parser = rate, requires = "recordings", allow_hyphen_values = true)]
    pub rate: Option<f64>,
    /// The latent coordinates that drive the display: `meaning`, those that the model's file names, or `z1`, as in the thesis.
    #[arg(long, value_name = "DRIVER", default_value = "meaning", value_parser = ["meaning", "z1"])]
    pub driver: String,
    /// An emulated bench: a built-in name or a file.
    #[arg(
        short = 'b',
        long,
        value_name = "NAME|FILE",
        default_value = palpate_files::DEFAULT_BENCH
    )]
    pub bench: String,
    /// Person whose fingers feel the display: a built-in name or a file.
    #[arg(long, value_name = "NAME|FILE", default_value = "typical")]
    pub person: String,
    /// Level of a texture over the wearer's threshold, dB; left out: 5.
    #[arg(long, value_name = "DB", allow_hyphen_values = true)]
    pub level: Option<f64>,
    /// Seed of the people, the strokes and the draws; the default model was trained on strokes of seed 1.
    #[arg(long, value_name = "N", default_value_t = 2, value_parser = super::whole::<u64, 0, { u64::MAX }>, allow_hyphen_values = true)]
    pub seed: u64,
    /// Draw the ratings into this file (.svg).
    #[arg(long, value_name = "FILE")]
    pub svg: Option<PathBuf>,
    /// Overwrite existing files even if hil did not write them.
    #[arg(short = 'f', long)]
    pub force: bool,
    /// Print JSON in place of a table.
    #[arg(long)]
    pub json: bool,
}

/// Options of `hil texture encode`.
#[derive(Clone, Debug, Args)]
pub struct EncodeArgs {
    /// `default`, `thesis` or a model file (.safetensors).
    #[arg(value_name = "MODEL|NAME")]
    pub model: String,
    /// Raw rows (CSV). With a header, the model's names for its features select the columns. Otherwise
    /// there must be as many columns as features. A recipe may stand for its recording, or lie beside it.
    pub file: PathBuf,
    /// How the recording is to be read: a recipe, such as `hil import` proposes (default: FILE itself where it is one, or FILE
    /// with the ending .toml).
    #[arg(long, value_name = "FILE", conflicts_with = "columns")]
    pub recipe: Option<PathBuf>,
    /// The columns to read, by what their names begin with, in the order of the file.
    #[arg(long, value_name = "PREFIX")]
    pub columns: Option<String>,
    /// Only the windows that are newest at each onset; onsets are this far apart, from the first row on
    /// (default: every window).
    #[arg(long, value_name = "T", value_parser = positive, requires = "rate", allow_hyphen_values = true)]
    pub soa_ms: Option<f64>,
    /// Rows per second, for --soa-ms and where no column says when rows came; another rate than times say or the model was
    /// trained on is refused.
    #[arg(long, value_name = "HZ", value_parser = rate, allow_hyphen_values = true)]
    pub rate: Option<f64>,
    /// The column of times, and its unit: s, ms, us or ns (default: a first column time_us).
    #[arg(long, value_name = "COLUMN[:UNIT]")]
    pub time: Option<palpate_files::TimeColumn>,
    /// Encode rows of another rate than the model was trained on, with a note.
    #[arg(long)]
    pub any_rate: bool,
    /// Add the error with which the model's decoder rebuilds each window, in shares of each feature's range, squared.
    #[arg(long)]
    pub error: bool,
    /// Print a JSON array in place of CSV.
    #[arg(long)]
    pub json: bool,
}

/// Options of `hil texture export`.
#[derive(Debug, Args)]
pub struct ExportArgs {
    /// `default`, `thesis` or a model file (.safetensors).
    #[arg(value_name = "MODEL|NAME")]
    pub model: String,
    /// File to write (.onnx).
    #[arg(short = 'o', long, value_name = "FILE")]
    pub out: PathBuf,
    /// Overwrite existing files even if hil did not write them.
    #[arg(short = 'f', long)]
    pub force: bool,
}
