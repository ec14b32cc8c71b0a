//! Options of the commands that compare, decide and try: `hil diff`, `hil review`, `hil test`.

use std::path::PathBuf;

use clap::{Args, Subcommand};

use super::whole;

/// A signal's name and the output it was clipped to.
fn pin(text: &str) -> Result<(String, (u8, u8)), String> {
    let parsed = text.rsplit_once('=').and_then(|(name, output)| {
        let (board, channel) = output.split_once(':')?;
        Some((
            name.to_owned(),
            (board.parse().ok()?, channel.parse().ok()?),
        ))
    });
    parsed.ok_or_else(|| "expected a name, board and channel, such as D0=0:3".into())
}

/// A band for edges.
fn tolerance(text: &str) -> Result<f64, String> {
    match text.parse() {
        Ok(v) if (0.0..=10_000.0).contains(&v) => Ok(v),
        _ => Err("expected 0 to 10000".into()),
    }
}

/// Options of `hil diff`.
#[derive(Debug, Args)]
pub struct DiffArgs {
    /// A golden (.snap), a schedule (.jsonl) or recorded contacts (.csv).
    pub a: PathBuf,
    /// Another one of the same kind; of a schedule, also a logic analyser's capture of its pins (.vcd, .csv).
    pub b: PathBuf,
    /// Which output a signal of the capture is (default: by names like b0_ch3, else in the order of the wires).
    /// Repeatable.
    #[arg(long, value_name = "NAME=BOARD:CHANNEL", value_parser = pin)]
    pub pin: Vec<(String, (u8, u8))>,
    /// Edges so far apart are in the same place (default: 0, and 2 where one of the two is of real hardware).
    #[arg(long, value_name = "MS", value_parser = tolerance, allow_hyphen_values = true)]
    pub tolerance_ms: Option<f64>,
    /// Recorded contacts so far apart are in the same place (default: 0).
    #[arg(long, value_name = "MM", value_parser = tolerance, allow_hyphen_values = true)]
    pub tolerance_mm: Option<f64>,
    /// Print every difference as a JSON array of {text, meaning}.
    #[arg(long)]
    pub json: bool,
    /// Print nothing but errors: the exit status tells.
    #[arg(long, conflicts_with = "json")]
    pub quiet: bool,
}

/// Options of `hil review`.
#[derive(Debug, Args)]
pub struct ReviewArgs {
    /// What to do without being asked.
    #[command(subcommand)]
    pub action: Option<ReviewAction>,
    /// Folder of the goldens (default: fixtures/goldens here or above).
    #[arg(long, value_name = "DIR", global = true)]
    pub goldens: Option<PathBuf>,
    /// Write everything that waits as one page, and ask nothing.
    #[arg(long, value_name = "FILE")]
    pub html: Option<PathBuf>,
}

/// Decisions without a question.
#[derive(Debug, Subcommand)]
pub enum ReviewAction {
    /// Accept what waits: everything, or the scenes or goldens named.
    Accept {
        /// `sphere-along`, or `sphere-along.margins`.
        names: Vec<String>,
        /// Why, kept with the golden.
        #[arg(long, value_name = "TEXT")]
        why: Option<String>,
    },
    /// Let what waits go: everything, or the scenes or goldens named.
    Reject {
        /// `sphere-along`, or `sphere-along.margins`.
        names: Vec<String>,
    },
}

/// Options of `hil test`.
#[derive(Debug, Args)]
pub struct TestArgs {
    /// Part of a built-in scene's name, or a scene file (default: every built-in scene).
    pub filter: Option<String>,
    /// A built-in bench or a file (default: emulated).
    #[arg(long, value_name = "NAME|FILE")]
    pub bench: Option<String>,
    /// A CAN interface, in place of the bench's; once a bus of the layout. The trials are real then.
    #[arg(long, value_name = "IFACE")]
    pub can: Vec<String>,
    /// An I2C adapter (/dev/i2c-N), in place of the bench's; once a bus of the outputs.
    #[arg(long, value_name = "DEVICE")]
    pub i2c: Vec<PathBuf>,
    /// Seed of all randomness.
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = whole::<u64, 0, { u64::MAX }>, allow_hyphen_values = true)]
    pub seed: u64,
    /// Try a trial that fails so many times more; one that passes then is told to be unstable.
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = whole::<u32, 0, 10>, allow_hyphen_values = true)]
    pub retries: u32,
    /// Trials that are known to fail, with reasons.
    #[arg(long, value_name = "FILE")]
    pub quarantine: Option<PathBuf>,
    /// Write the results as JUnit XML, measurements as properties.
    #[arg(long, value_name = "FILE")]
    pub junit: Option<PathBuf>,
    /// Print the results as one JSON object.
    #[arg(long)]
    pub json: bool,
    /// Print nothing but errors.
    #[arg(long, conflicts_with = "json")]
    pub quiet: bool,
}
