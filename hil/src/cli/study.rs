//! Options of `hil study`.

use clap::{Args, Subcommand};

/// What to do with a study.
#[derive(Debug, Subcommand)]
pub enum StudyAction {
    /// Let simulated people answer a protocol, and print how well their truth is found again, and how many people a
    /// difference needs.
    Simulate(SimulateArgs),
}

/// Options of `hil study simulate`.
#[derive(Debug, Args)]
pub struct SimulateArgs {
    /// A built-in protocol or a file.
    #[arg(value_name = "NAME|FILE")]
    pub protocol: String,
    /// How many people answer; of a rating half of them rate each condition.
    #[arg(long, value_name = "N", default_value_t = 20, value_parser = super::whole::<u32, 1, 10_000>, allow_hyphen_values = true)]
    pub people: u32,
    /// Seed of the people and their answers.
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = super::whole::<u64, 0, { u64::MAX }>, allow_hyphen_values = true)]
    pub seed: u64,
    /// Print JSON in place of text.
    #[arg(long)]
    pub json: bool,
}
