//! Options of `hil import`.

use std::path::PathBuf;

use clap::Args;
use palpate_files::{Gain, TimeColumn};

use super::rate;

/// Options of `hil import`.
#[derive(Debug, Args)]
pub struct ImportArgs {
    /// Recorded taxels: a table of text, an array, messages (MCAP).
    pub file: PathBuf,
    /// Sensor layout: a built-in name or a file (default: a built-in one with as many columns).
    #[arg(long, value_name = "NAME|FILE")]
    pub layout: Option<String>,
    /// Rows per second of a recording without times (default: frequency_hz of meta_data.csv beside it, else 100).
    #[arg(long, value_name = "HZ", value_parser = rate, allow_hyphen_values = true)]
    pub rate: Option<f64>,
    /// Column of the rows' times, and its unit: s, ms, us, ns or date (default: a
    /// column whose name says that it holds times).
    #[arg(long, value_name = "COLUMN[:UNIT]", conflicts_with = "rate")]
    pub time: Option<TimeColumn>,
    /// The topic whose messages are rows, in an MCAP file of another program (default: the one with the most numbers).
    #[arg(long, value_name = "TOPIC")]
    pub topic: Option<String>,
    /// Counts per unit and at 0, where the recording has values in another unit (default: by their noise).
    #[arg(long, value_name = "COUNTS[:OFFSET]", allow_hyphen_values = true)]
    pub gain: Option<Gain>,
    /// Write the recipe into this file in place of standard output.
    #[arg(short = 'o', long, value_name = "FILE")]
    pub out: Option<PathBuf>,
    /// Overwrite a file that is there.
    #[arg(short = 'f', long)]
    pub force: bool,
}
