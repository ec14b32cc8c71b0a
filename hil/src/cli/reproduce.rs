//! Options of `hil reproduce`.

use std::path::PathBuf;

use clap::Args;

use super::Voice;

/// Options of `hil reproduce`.
#[derive(Debug, Args)]
pub struct ReproduceArgs {
    /// Rows to compute, such as eq-5.2 or fig-4.7; the begin of a name stands for all rows with it (default: all).
    #[arg(value_name = "ROW")]
    pub rows: Vec<String>,
    /// Write a page with all rows.
    #[arg(long, value_name = "FILE")]
    pub html: Option<PathBuf>,
    /// Overwrite existing files even if hil did not write them.
    #[arg(short = 'f', long)]
    pub force: bool,
    /// Amount that the command says.
    #[command(flatten)]
    pub voice: Voice,
}
