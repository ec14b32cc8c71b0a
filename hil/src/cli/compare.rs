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
    /// Another file of the same kind. A schedule also compares with a logic analyser's capture (.vcd, .csv).
    pub b: PathBuf,
    /// Output of a signal in the capture; repeatable (default: by names like b0_ch3, else in the order of
    /// the wires).
    #[arg(long, value_name = "NAME=BOARD:CHANNEL", value_parser = pin)]
    pub pin: Vec<(String, (u8, u8))>,
    /// Largest distance in time of edges that count as equal, ms (default: 0; 2 if a file comes from real
    /// hardware).
    #[arg(long, value_name = "MS", value_parser = tolerance, allow_hyphen_values = true)]
    pub tolerance_ms: Option<f64>,
    /// Largest distance of contacts that count as equal, mm (default: 0).
    #[arg(long, value_name = "MM", value_parser = tolerance, allow_hyphen_values = true)]
    pub tolerance_mm: Option<f64>,
    /// Print every difference as a JSON array of {text, meaning}.
    #[arg(long)]
    pub json: bool,
    /// Print nothing but errors; use the exit status.
    #[arg(long, conflicts_with = "json")]
    pub quiet: bool,
}

/// Options of `hil review`.
#[derive(Debug, Args)]
pub struct ReviewArgs {
    /// A decision without questions.
    #[command(subcommand)]
    pub action: Option<ReviewAction>,
    /// Folder of the goldens (default: fixtures/goldens here or above).
    #[arg(long, value_name = "DIR", global = true)]
    pub goldens: Option<PathBuf>,
    /// Write all waiting goldens as one page, without questions.
    #[arg(long, value_name = "FILE")]
    pub html: Option<PathBuf>,
    /// Overwrite files that are no earlier output of hil.
    #[arg(long, requires = "html")]
    pub force: bool,
}

/// Decisions without a question.
#[derive(Debug, Subcommand)]
pub enum ReviewAction {
    /// Accept all waiting goldens, or the named ones.
    Accept {
        /// A scene (`sphere-along`) or one golden (`sphere-along.schedule`).
        names: Vec<String>,
        /// The reason, kept in the golden.
        #[arg(long, value_name = "TEXT")]
        why: Option<String>,
    },
    /// Discard all waiting changes, or those of the named goldens.
    Reject {
        /// A scene (`sphere-along`) or one golden (`sphere-along.schedule`).
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
    /// A CAN interface in place of the bench's; give it once per bus of the layout. Makes the trials real.
    #[arg(long, value_name = "IFACE")]
    pub can: Vec<String>,
    /// An I2C adapter (/dev/i2c-N) in place of the bench's; give it once per bus of the outputs.
    #[arg(long, value_name = "DEVICE")]
    pub i2c: Vec<PathBuf>,
    /// Seed of all randomness.
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = whole::<u64, 0, { u64::MAX }>, allow_hyphen_values = true)]
    pub seed: u64,
    /// Repeat a failed trial up to N times. A trial that then passes is reported as unstable.
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = whole::<u32, 0, 10>, allow_hyphen_values = true)]
    pub retries: u32,
    /// File of trials that are known to fail, with reasons.
    #[arg(long, value_name = "FILE")]
    pub quarantine: Option<PathBuf>,
    /// Write the results as JUnit XML, measurements as properties.
    #[arg(long, value_name = "FILE")]
    pub junit: Option<PathBuf>,
    /// Print the results as one JSON object.
    #[arg(long)]
    pub json: bool,
    /// Overwrite files that are no earlier output of hil.
    #[arg(long)]
    pub force: bool,
    /// Print nothing but errors.
    #[arg(long, conflicts_with = "json")]
    pub quiet: bool,
}
