//! Options of `hil design`.

use std::path::PathBuf;

use clap::Args;

use super::{Voice, ranges, within};

/// Most numbers of one list.
const MOST: usize = 1000;

/// Numbers and ranges of them between commas, within bounds.
fn numbers(text: &str, low: f64, high: f64) -> Result<Numbers, String> {
    let expected = || {
        format!(
            "expected numbers from {low} to {high} between commas or as FROM..TO:STEP, at most {MOST}"
        )
    };
    let one = |part: &String| within(part, (low, high), "").ok();
    let all: Option<Vec<f64>> = ranges::list(text)?.iter().map(one).collect();
    all.filter(|all| all.len() <= MOST)
        .map(Numbers)
        .ok_or_else(expected)
}

/// Values that are tried, in the order of the command line.
#[derive(Clone, Debug, PartialEq)]
pub struct Numbers(pub Vec<f64>);

/// Options of `hil design`: lists between commas, of which every combination is computed.
#[derive(Debug, Args)]
pub struct DesignArgs {
    /// Wires to start from, built in or files: their material and their seat on the finger.
    #[arg(
        long,
        value_name = "NAME|FILE,..",
        value_delimiter = ',',
        default_value = "taut,final-75um,loose-50um"
    )]
    pub wire: Vec<String>,
    /// Alloys, built in or files.
    #[arg(
        long,
        value_name = "NAME|FILE,..",
        value_delimiter = ',',
        default_value = "low"
    )]
    pub alloy: Vec<String>,
    /// Diameters in place of the wire's, um. Resistance and heat to air follow.
    #[arg(long, value_name = "UM,..", value_parser = |t: &str| numbers(t, 10.0, 1000.0), allow_hyphen_values = true)]
    pub diameter_um: Option<Numbers>,
    /// Lengths in place of the wire's, mm.
    #[arg(long, value_name = "MM,..", value_parser = |t: &str| numbers(t, 0.5, 100.0), allow_hyphen_values = true)]
    pub length_mm: Option<Numbers>,
    /// Constant stresses in place of the wire's, MPa.
    #[arg(long, value_name = "MPA,..", value_parser = |t: &str| numbers(t, 0.0, 1000.0), allow_hyphen_values = true)]
    pub stress_mpa: Option<Numbers>,
    /// Currents of a pulse, A.
    #[arg(long, value_name = "A,..", default_value = "0.99,1.4,1.97", value_parser = |t: &str| numbers(t, 0.01, 20.0), allow_hyphen_values = true)]
    pub current_a: Numbers,
    /// Pulses of a burst, one per PWM period of 5.079 ms.
    #[arg(long, value_name = "N,..", default_value = "1,2,4,7", value_parser = |t: &str| numbers(t, 1.0, 100.0), allow_hyphen_values = true)]
    pub pulses: Numbers,
    /// Time from burst to burst, ms.
    #[arg(long, value_name = "MS,..", default_value = "58.5,117,234", value_parser = |t: &str| numbers(t, 5.0, 10_000.0), allow_hyphen_values = true)]
    pub cadence_ms: Numbers,
    /// Mean electrical power of the wire, mW: the width of the pulses follows from it.
    #[arg(long, value_name = "MW,..", default_value = "20", value_parser = |t: &str| numbers(t, 0.01, 1000.0), allow_hyphen_values = true)]
    pub power_mw: Numbers,
    /// The person who feels it, built in or a file.
    #[arg(long, value_name = "NAME|FILE", default_value = "typical")]
    pub person: String,
    /// Show the frequency response of this bench's wire from 10 to 300 Hz in place of the table, as a vibrometer would.
    #[arg(
        long,
        value_name = "BENCH|FILE",
        conflicts_with_all = ["wire", "alloy", "diameter_um", "length_mm", "stress_mpa", "current_a", "pulses", "cadence_ms", "power_mw", "seconds"]
    )]
    pub response: Option<String>,
    /// Time for which a wire is driven, s.
    #[arg(long, value_name = "S", default_value_t = 10.0, value_parser = |t: &str| within(t, (3.0, 3600.0), " s"), allow_hyphen_values = true)]
    pub seconds: f64,
    /// Write every point as a table, .csv.
    #[arg(short = 'o', long, value_name = "FILE")]
    pub out: Option<PathBuf>,
    /// Write a page with the plot and the points that no other beats.
    #[arg(long, value_name = "FILE")]
    pub html: Option<PathBuf>,
    /// Overwrite existing files even if hil did not write them.
    #[arg(short = 'f', long)]
    pub force: bool,
    /// Amount that the command says.
    #[command(flatten)]
    pub voice: Voice,
}
