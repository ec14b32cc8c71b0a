//! Options of `hil contacts`.

use std::path::PathBuf;

use clap::{Args, ValueEnum};
use palpate_core::contact::{Norm, Scope};
use palpate_core::skin::{Axes, ThresholdRule};
use palpate_core::units::Duration;
use palpate_files::{DRIFT_S, Gain, THRESHOLD_FLOOR, THRESHOLD_SIGMAS, TimeColumn};

use super::{positive, rate, whole, within};

/// Handling of rows that repeat the row before.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum StaleArg {
    /// Compress repeated rows like any other row.
    Keep,
    /// Leave repeated rows out.
    Skip,
}

/// Rules that find the contact threshold.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Threshold {
    /// The largest value of the first row after the reference.
    Auto,
    /// Threshold from every taxel's own noise.
    PerTaxel,
    /// Raw counts.
    Counts(f32),
}

impl Threshold {
    /// Rule that the baseline takes; per taxel as scenes have it by default.
    pub const fn rule(self) -> ThresholdRule {
        match self {
            Self::Auto => ThresholdRule::Auto { margin: 0.0 },
            Self::PerTaxel => ThresholdRule::PerTaxel {
                sigmas: THRESHOLD_SIGMAS as f32,
                floor: THRESHOLD_FLOOR as f32,
            },
            Self::Counts(counts) => ThresholdRule::Fixed { counts },
        }
    }

    /// Time constant of the reference's drift: seconds where they are given, otherwise what this threshold needs.
    pub fn drift(self, seconds: Option<f64>) -> Option<Duration> {
        let seconds = seconds.or((self == Self::PerTaxel).then_some(DRIFT_S));
        seconds.map(|s| Duration::from_micros((s * 1e6).round() as u64))
    }
}

/// A rule by its name, or raw counts.
///
/// # Errors
/// A sentence that says what was expected.
pub fn threshold(text: &str) -> Result<Threshold, String> {
    match text {
        "auto" => return Ok(Threshold::Auto),
        "per-taxel" => return Ok(Threshold::PerTaxel),
        _ => {}
    }
    match text.parse() {
        Ok(counts) if (0.0..=1e6).contains(&counts) => Ok(Threshold::Counts(counts)),
        _ => Err("expected auto, per-taxel or raw counts from 0 to 1000000".into()),
    }
}

/// Options of `hil contacts`.
#[derive(Debug, Args)]
pub struct ContactsArgs {
    /// Recorded taxels: a table of text, an array, messages (MCAP); or their recipe (TOML).
    pub file: PathBuf,
    /// Sensor layout: a built-in name or a file (default: that of the recipe).
    #[arg(long, value_name = "NAME|FILE")]
    pub layout: Option<String>,
    /// Recipe that tells how to read the recording, such as `hil import` proposes (default: FILE itself if it is a recipe,
    /// else FILE with the ending .toml).
    #[arg(long, value_name = "FILE", conflicts_with_all = ["columns", "gain"])]
    pub recipe: Option<PathBuf>,
    /// Largest number of contacts K_C per module.
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = whole::<u16, 1, 1024>, allow_hyphen_values = true)]
    pub kc: u16,
    /// Static intensity levels K_I, found over the whole recording.
    #[arg(long, value_name = "N", default_value_t = 10, value_parser = whole::<u16, 1, 256>, allow_hyphen_values = true)]
    pub ki: u16,
    /// Levels by just noticeable differences, each this fraction above the one below, from the weakest intensity up
    /// (default: --ki levels).
    #[arg(long, value_name = "FRACTION", conflicts_with = "ki", value_parser = |t: &str| within(t, (0.001, 10.0), ""), allow_hyphen_values = true)]
    pub weber: Option<f64>,
    /// Find intensities and levels along x, y and z, (4.9) to (4.15), in place of their magnitudes; levels are numbered by
    /// strength.
    #[arg(long, conflicts_with = "weber")]
    pub vectors: bool,
    /// Number of contact-free rows at the start that make the reference.
    #[arg(long, value_name = "N", default_value_t = palpate_files::REFERENCE_ROWS, value_parser = whole::<u32, 1, 100_000>, allow_hyphen_values = true)]
    pub reference_frames: u32,
    /// Contact threshold: per-taxel (from every taxel's own noise), auto (as published: the largest value of the first row
    /// after the reference) or raw counts.
    #[arg(long, default_value = "per-taxel", value_name = "auto|per-taxel|COUNTS", value_parser = threshold, allow_hyphen_values = true)]
    pub threshold: Threshold,
    /// Let the reference follow taxels that are not in contact, with this time constant (default: 5 with per-taxel
    /// thresholds; with other thresholds the reference stays fixed).
    #[arg(long, value_name = "SECONDS", value_parser = positive, allow_hyphen_values = true)]
    pub drift_s: Option<f64>,
    /// Leave out taxels whose first row is more than K standard deviations from their axis's mean (default: none).
    #[arg(long, value_name = "K", value_parser = positive, allow_hyphen_values = true)]
    pub faulty_deviations: Option<f64>,
    /// Apply K_C and K_I to each module, or to the whole skin.
    #[arg(long, value_name = "module|skin", default_value = "module", value_parser = palpate_files::scope)]
    pub scope: Scope,
    /// Half the summed moves of the centroids at which K-means ends: zeta_C of (4.8), mm.
    #[arg(long, value_name = "MM", default_value = "0.001", value_parser = |t: &str| within(t, (0.0, 100.0), " mm"), allow_hyphen_values = true)]
    pub stop_mm: f64,
    /// Exponent p of the weights ||s||^p.
    #[arg(long, value_name = "P", default_value = "1", value_parser = |t: &str| within(t, (0.0, 16.0), ""), allow_hyphen_values = true)]
    pub weight_exponent: f64,
    /// Norm l of the weights: sum of absolute values, Euclidean, or largest.
    #[arg(long, value_name = "l1|l2|linf", default_value = "l2", value_parser = palpate_files::norm)]
    pub norm: Norm,
    /// Axes to use: all three, or the normal one.
    #[arg(long, value_name = "xyz|z", default_value = "xyz", value_parser = palpate_files::axes_named)]
    pub axes: Axes,
    /// Rows per second of a recording without a time_us column (default: frequency_hz of meta_data.csv
    /// beside it).
    #[arg(long, value_name = "HZ", value_parser = rate, allow_hyphen_values = true)]
    pub rate: Option<f64>,
    /// Column of the rows' times, and its unit: s, ms, us, ns or date (default: a column whose name says that it holds
    /// times).
    #[arg(long, value_name = "COLUMN[:UNIT]", conflicts_with = "rate")]
    pub time: Option<TimeColumn>,
    /// Read the columns whose names begin with PREFIX, in the order of the numbers in their names (default: `txl1_x` and so
    /// on, or the only columns whose count fits).
    #[arg(long, value_name = "PREFIX")]
    pub columns: Option<String>,
    /// The topic whose messages are rows, in an MCAP file of another program (default: the one with the most numbers).
    #[arg(long, value_name = "TOPIC")]
    pub topic: Option<String>,
    /// Counts per unit, and counts at zero, for a recording in another unit than counts (`100:32768`).
    #[arg(long, value_name = "COUNTS[:OFFSET]", allow_hyphen_values = true)]
    pub gain: Option<Gain>,
    /// Join both sides of a jump of the recording's clock, without the gap.
    #[arg(long)]
    pub split_jumps: bool,
    /// Seed of the k-means++ draws.
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = whole::<u64, 0, { u64::MAX }>, allow_hyphen_values = true)]
    pub seed: u64,
    /// Handling of rows that repeat the row before.
    #[arg(long, value_enum, default_value_t = StaleArg::Keep)]
    pub replay_stale: StaleArg,
    /// Write contacts.csv into this folder in place of standard output.
    #[arg(short = 'o', long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// Overwrite existing files even if hil did not write them.
    #[arg(short = 'f', long)]
    pub force: bool,
    /// Print a JSON array of objects; the keys are the CSV's columns, and `vector` with --vectors.
    #[arg(long, conflicts_with = "out")]
    pub json: bool,
    /// Print no notes, only the contacts and errors.
    #[arg(short = 'q', long)]
    pub quiet: bool,
}
