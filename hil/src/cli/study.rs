//! Options of `hil study`.

use std::net::SocketAddr;
use std::path::PathBuf;

use clap::{Args, Subcommand};

use super::{Buses, NewProtocol, SERVE_AT, serve_at};

/// Actions on a study.
#[derive(Debug, Subcommand)]
pub enum StudyAction {
    /// Write a protocol of one's own, which begins as a built-in one.
    New(NewProtocol),
    /// Conduct a participant's session: prints the addresses of the participant's and the experimenter's page.
    Run(StudyRunArgs),
    /// Write the analysis of the answers into DIR/analysis: a page with figures, tables, wearers' files.
    Analyse(AnalyseArgs),
    /// Let simulated people answer a protocol, and print how well their truth is found again, and how many people a
    /// difference needs.
    Simulate(SimulateArgs),
}

/// Options of `hil study run`.
#[derive(Debug, Args)]
pub struct StudyRunArgs {
    /// A built-in protocol or a file.
    #[arg(value_name = "NAME|FILE")]
    pub protocol: String,
    /// The participant's number, which no other one has.
    #[arg(long, value_name = "N", value_parser = super::whole::<u32, 1, 1_000_000>, allow_hyphen_values = true)]
    pub participant: u32,
    /// The study's folder: one protocol, all participants.
    #[arg(short = 'o', long, value_name = "DIR")]
    pub out: PathBuf,
    /// Bench of the study. The seed is that of orders.
    #[command(flatten)]
    pub on: Buses,
    /// Address of the pages: PORT of this computer or ADDRESS or ADDRESS:PORT; port 0 takes a free one.
    #[arg(long, value_name = "ADDRESS", default_value = SERVE_AT, value_parser = serve_at)]
    pub at: SocketAddr,
    /// Go on with a session of this number that is not over.
    #[arg(long)]
    pub resume: bool,
    /// A simulated person answers, as fast as the emulated bench plays; no page is served.
    #[arg(long)]
    pub simulated: bool,
    /// Compute the session's dose, print it, and end.
    #[arg(long, conflicts_with_all = ["resume", "simulated"])]
    pub dose: bool,
}

/// Options of `hil study analyse`.
#[derive(Debug, Args)]
pub struct AnalyseArgs {
    /// The study's folder.
    #[arg(value_name = "DIR")]
    pub dir: PathBuf,
    /// Another study's folder: what both rated is compared, such as surfaces under the finger and on the wires.
    #[arg(long, value_name = "DIR")]
    pub beside: Option<PathBuf>,
    /// Print the analysis as JSON in place of text.
    #[arg(long)]
    pub json: bool,
}

/// Options of `hil study simulate`.
#[derive(Debug, Args)]
pub struct SimulateArgs {
    /// A built-in protocol or a file.
    #[arg(value_name = "NAME|FILE")]
    pub protocol: String,
    /// Number of people who answer; half of them rate each condition of a rating.
    #[arg(long, value_name = "N", default_value_t = 20, value_parser = super::whole::<u32, 1, 10_000>, allow_hyphen_values = true)]
    pub people: u32,
    /// Seed of the people and their answers.
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = super::whole::<u64, 0, { u64::MAX }>, allow_hyphen_values = true)]
    pub seed: u64,
    /// Print JSON in place of text.
    #[arg(long)]
    pub json: bool,
}
