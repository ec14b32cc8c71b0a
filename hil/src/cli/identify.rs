//! Options of `hil identify`.

use std::path::PathBuf;

use clap::{Args, ValueEnum};
use palpate_files::TimeColumn;

use super::{Voice, ranges, rate};

/// Quantities that a trace measures.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum SignalArg {
    /// A column displacement_um: the wire's middle, positive towards the finger.
    Displacement,
    /// A column resistance_ohm: between the terminals.
    Resistance,
}

/// Options of `hil identify`.
#[derive(Debug, Args)]
pub struct IdentifyArgs {
    /// The trace (CSV): time_us, current_a, and displacement_um or resistance_ohm. A current holds from its row on.
    pub trace: PathBuf,
    /// Quantity that the trace measures.
    #[arg(long, value_enum, default_value = "displacement")]
    pub signal: SignalArg,
    /// The bench whose wire, mount and finger it was taken of (default: emulated).
    #[arg(
        short = 'b',
        long,
        value_name = "NAME|FILE",
        default_value = palpate_files::DEFAULT_BENCH
    )]
    pub bench: String,
    /// A value in place of the bench's (`wire.kind=final-75um`, `mount.sag_um=75`). Repeatable.
    #[arg(short = 's', long, value_name = "KEY=VALUE", value_parser = ranges::key_value)]
    pub set: Vec<String>,
    /// Rows per second of a trace without times.
    #[arg(long, value_name = "HZ", value_parser = rate, allow_hyphen_values = true)]
    pub rate: Option<f64>,
    /// The column of times, and its unit: s, ms, us or ns (default: a first column `time_us`).
    #[arg(long, value_name = "COLUMN[:UNIT]", conflicts_with = "rate")]
    pub time: Option<TimeColumn>,
    /// Write what was found as evidence for `hil calibrate` (TOML).
    #[arg(short = 'o', long, value_name = "FILE")]
    pub out: Option<PathBuf>,
    /// Overwrite an existing file even if hil did not write it.
    #[arg(short = 'f', long)]
    pub force: bool,
    /// Amount that the command says.
    #[command(flatten)]
    pub voice: Voice,
}
