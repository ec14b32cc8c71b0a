//! Options of `hil calibrate`.

use std::path::PathBuf;

use clap::{Args, ValueEnum};

use super::{Voice, ranges, whole};

/// Wires that the law plans with.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Planned {
    /// Each draw's own, as if they had been identified.
    Own,
    /// The bench's, as its file has them.
    Nominal,
}

/// Options of `hil calibrate`.
#[derive(Debug, Args)]
pub struct CalibrateArgs {
    /// The bench, built in or a file.
    #[arg(value_name = "BENCH", default_value = palpate_files::DEFAULT_BENCH)]
    pub bench: String,
    /// Evidence, built in or a file. Repeatable (default: published).
    #[arg(long, value_name = "NAME|FILE", default_value = "published")]
    pub evidence: Vec<String>,
    /// Priors, built in or a file.
    #[arg(long, value_name = "NAME|FILE", default_value = "default")]
    pub priors: String,
    /// Wires that the law plans with.
    #[arg(long, value_enum, default_value = "own")]
    pub planned: Planned,
    /// Draws to begin with; more follow until the effective sample size is 200.
    #[arg(long, value_name = "N", default_value_t = 1000, value_parser = whole::<u64, 10, 1_000_000>, allow_hyphen_values = true)]
    pub draws: u64,
    /// Most draws.
    #[arg(long, value_name = "N", default_value_t = 10_000, value_parser = whole::<u64, 10, 1_000_000>, allow_hyphen_values = true)]
    pub most: u64,
    /// Seed of the draws.
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = whole::<u64, 0, { i64::MAX as u64 }>, allow_hyphen_values = true)]
    pub seed: u64,
    /// Draws at the same time (default: one per core).
    #[arg(short = 'j', long, value_name = "N", value_parser = whole::<usize, 1, 1024>, allow_hyphen_values = true)]
    pub jobs: Option<usize>,
    /// A value in place of the bench's (`mount.sag_um=200`). Repeatable.
    #[arg(short = 's', long, value_name = "KEY=VALUE", value_parser = ranges::key_value)]
    pub set: Vec<String>,
    /// Write the band for runs on the bench, which names the file as its `band` (TOML).
    #[arg(short = 'o', long, value_name = "FILE")]
    pub out: Option<PathBuf>,
    /// Overwrite a file that is no earlier output of hil.
    #[arg(short = 'f', long)]
    pub force: bool,
    /// Amount that the command says.
    #[command(flatten)]
    pub voice: Voice,
}
