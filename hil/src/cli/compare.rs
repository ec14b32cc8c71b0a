//! Options of the commands that compare, decide and try: `hil diff`, `hil review`, `hil test`.

use std::path::PathBuf;

use clap::{Args, Subcommand};

use super::{Buses, Voice, ranges, whole, within};

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

/// A stretch of the run.
fn window(text: &str) -> Result<(f64, f64), String> {
    let parsed = text
        .split_once("..")
        .and_then(|(from, to)| Some((from.parse().ok()?, to.parse().ok()?)));
    let good = |w: &(f64, f64)| w.0 >= 0.0 && w.0 < w.1 && w.1 <= 86_400.0;
    let expected = || "expected FROM..TO, seconds of the run, such as 0.5..2.5".into();
    parsed.filter(good).ok_or_else(expected)
}

/// A band for edges or places.
fn tolerance(text: &str) -> Result<f64, String> {
    within(text, (0.0, 10_000.0), "")
}

/// Options of `hil diff`.
#[derive(Clone, Debug, Args)]
pub struct DiffArgs {
    /// A golden (.snap), a schedule (.jsonl) or recorded contacts (.csv); a folder of `hil run --out` has the last two.
    pub a: PathBuf,
    /// Another file of the same kind. A schedule also compares with a capture of its pins (.vcd, .fst, .ghw, .csv).
    pub b: PathBuf,
    /// Output of a signal in the capture; repeatable (default: by names like b0_ch3, else in the order of
    /// the wires).
    #[arg(long, value_name = "NAME=BOARD:CHANNEL", value_parser = pin)]
    pub pin: Vec<(String, (u8, u8))>,
    /// Part of the run that a capture shall show, seconds: every burst that the schedule has there must be in it
    /// whole (default: all bursts of the schedule).
    #[arg(long, value_name = "FROM..TO", value_parser = window, allow_hyphen_values = true)]
    pub window: Option<(f64, f64)>,
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
    #[arg(short = 'q', long, conflicts_with = "json")]
    pub quiet: bool,
}

/// Options of `hil review`.
#[derive(Debug, Args)]
pub struct ReviewArgs {
    /// A decision without questions.
    #[command(subcommand)]
    pub action: Option<ReviewAction>,
    /// Folder of the goldens, or of the project they are in (default: fixtures/goldens or goldens, here or above).
    #[arg(long, value_name = "DIR", global = true)]
    pub goldens: Option<PathBuf>,
    /// Write all waiting goldens as one page, without questions.
    #[arg(long, value_name = "FILE")]
    pub html: Option<PathBuf>,
    /// Overwrite existing files even if hil did not write them.
    #[arg(short = 'f', long, requires = "html")]
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
    /// Parts of built-in scenes' names, scene files, or folders with scenes, benches and goldens (default: every
    /// built-in scene).
    #[arg(value_name = "NAME|FILE|DIR")]
    pub targets: Vec<String>,
    /// Only scenes whose name contains this.
    #[arg(long, value_name = "TEXT")]
    pub filter: Option<String>,
    /// Only trials that failed when this folder was last tried.
    #[arg(long)]
    pub last_failed: bool,
    /// Say what would be tried, and run nothing.
    #[arg(long, conflicts_with_all = ["accept", "junit", "html"])]
    pub list: bool,
    /// Keep the runs as the goldens of scenes that are files, in `goldens` beside them.
    #[arg(long)]
    pub accept: bool,
    /// Emulated trials at a time (default: as many as there are cores).
    #[arg(short = 'j', long, value_name = "N", value_parser = whole::<usize, 1, 256>, allow_hyphen_values = true)]
    pub jobs: Option<usize>,
    /// Bench of the runs.
    #[command(flatten)]
    pub on: Buses,
    /// A value in place of each scene's (`illusion.weber=0.1`) or the bench's (`bench.drive.current_ma=900`), as for
    /// `hil run`. Repeatable.
    #[arg(short = 's', long, value_name = "KEY=VALUE", value_parser = ranges::key_value)]
    pub set: Vec<String>,
    /// Repeat a failed trial up to N times. A trial that then passes is reported as unstable.
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = whole::<u32, 0, 10>, allow_hyphen_values = true)]
    pub retries: u32,
    /// File of trials that are known to fail, with reasons (default: `quarantine.toml` in the folder).
    #[arg(long, value_name = "FILE")]
    pub quarantine: Option<PathBuf>,
    /// Write the results as JUnit XML, measurements as properties.
    #[arg(long, value_name = "FILE")]
    pub junit: Option<PathBuf>,
    /// Overwrite existing files even if hil did not write them.
    #[arg(short = 'f', long)]
    pub force: bool,
    /// Write the results as one page.
    #[arg(long, value_name = "FILE")]
    pub html: Option<PathBuf>,
    /// Amount that the command says.
    #[command(flatten)]
    pub voice: Voice,
}
