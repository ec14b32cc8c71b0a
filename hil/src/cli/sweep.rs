//! Options of the commands about many runs: `hil sweep`, `hil compare`.

use std::path::PathBuf;

use clap::Args;

use super::{Command, Voice, ranges, whole, within};

/// Seeds, in the order in which they run.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Seeds(pub Vec<u64>);

/// Most seeds of a sweep.
const MOST_SEEDS: usize = 1_000_000;

/// `1..20` (both ends count), `3`, or several of these between commas.
fn seeds(text: &str) -> Result<Seeds, String> {
    let expected =
        || format!("expected seeds such as 1..20 (both ends count) or 3,5,8; at most {MOST_SEEDS}");
    let all = ranges::list(text)?;
    let all: Option<Vec<u64>> = all.iter().map(|seed| seed.parse().ok()).collect();
    all.filter(|all| all.len() <= MOST_SEEDS)
        .map(Seeds)
        .ok_or_else(expected)
}

/// `K/N`: the K-th of N parts.
fn part(text: &str) -> Result<(usize, usize), String> {
    let parsed = text
        .split_once('/')
        .and_then(|(k, n)| Some((k.parse().ok()?, n.parse().ok()?)));
    let good = |(k, n): &(usize, usize)| (1..=*n).contains(k);
    parsed
        .filter(good)
        .ok_or_else(|| "expected K/N, the K-th of N parts, such as 1/4".into())
}

/// Options of `hil sweep`.
#[derive(Debug, Args)]
pub struct SweepArgs {
    /// A built-in scene or a file.
    pub scene: String,
    /// Values that a key takes in turn: of the scene (`illusion.shape=1,2,3`, `illusion.soa_ms=100..130:10`), or after
    /// `bench.` of the bench. Both ends of a range count. Every combination of several keys runs. Repeatable.
    #[arg(short = 's', long, value_name = "KEY=VALUE,FROM..TO:STEP,..")]
    pub set: Vec<String>,
    /// Seeds of every combination: 1..20 (both ends count), 1..20:2, or 3,5,8.
    #[arg(long, value_name = "N..M", default_value = "1", value_parser = seeds, allow_hyphen_values = true)]
    pub seeds: Seeds,
    /// A built-in emulated bench or a file (default: the bench that the scene wants, or emulated).
    #[arg(short = 'b', long, value_name = "NAME|FILE")]
    pub bench: Option<String>,
    /// The table, .csv or .jsonl. Rows that it has are not computed again.
    #[arg(short = 'o', long, value_name = "FILE")]
    pub out: PathBuf,
    /// Write a page with plots: figures against each swept number, with their spread over seeds.
    #[arg(long, value_name = "FILE")]
    pub html: Option<PathBuf>,
    /// Compute only the K-th of N parts of the rows. `cat` joins tables of parts, and the command without --part puts
    /// the rows in order.
    #[arg(long, value_name = "K/N", value_parser = part)]
    pub part: Option<(usize, usize)>,
    /// Runs at a time (default: as many as there are cores).
    #[arg(short = 'j', long, value_name = "N", value_parser = whole::<usize, 1, 256>, allow_hyphen_values = true)]
    pub jobs: Option<usize>,
    /// Overwrite files that hil did not write, and rows of another sweep.
    #[arg(short = 'f', long)]
    pub force: bool,
    /// Amount that the command says.
    #[command(flatten)]
    pub voice: Voice,
}

/// Options of `hil compare`.
#[derive(Debug, Args)]
pub struct CompareArgs {
    /// A summary (JSON), a folder of `hil run --out`, a table of `hil sweep`, or a folder of earlier summaries.
    pub a: PathBuf,
    /// Another one of its kind (default: the folder's summaries are shown over time).
    pub b: Option<PathBuf>,
    /// Difference that counts as equal, percent of the larger number.
    #[arg(long, value_name = "PERCENT", default_value_t = 0.0, value_parser = |t: &str| within(t, (0.0, 100.0), ""), allow_hyphen_values = true)]
    pub tolerance_percent: f64,
    /// Write a page: figures beside each other, or the trends of a folder.
    #[arg(long, value_name = "FILE")]
    pub html: Option<PathBuf>,
    /// List every value that differs, beyond the figures that have a name.
    #[arg(long)]
    pub long: bool,
    /// Overwrite existing files even if hil did not write them.
    #[arg(short = 'f', long, requires = "html")]
    pub force: bool,
    /// Amount that the command says.
    #[command(flatten)]
    pub voice: Voice,
}

impl Command {
    /// Returns true if the command says nothing while it works.
    pub fn is_quiet(&self) -> bool {
        match self {
            // A live view has the terminal.
            Self::Run(args) => args.voice.quiet || args.watch,
            Self::Sweep(args) => args.voice.quiet,
            Self::Design(args) => args.voice.quiet,
            Self::Reproduce(args) => args.voice.quiet,
            Self::Compare(args) => args.voice.quiet,
            Self::Test(args) => args.voice.quiet,
            Self::Record(args) => args.voice.quiet,
            Self::Replay(args) => args.voice.quiet,
            // It asks a question, and lasts a second.
            Self::Pulse(_) => true,
            Self::Contacts(args) => args.quiet,
            Self::Diff(args) => args.quiet,
            _ => false,
        }
    }
}
