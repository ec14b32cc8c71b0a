//! A record of a run that is over, for other programs than `hil` itself.

use std::path::Path;

use palpate_files::{Format, Setup};
use palpate_run::{Failure, Outcome};

use super::run_files::{check, format_of_record, write};
use palpate_live::output::Outputs;

/// Writes one record of a run; the ending of the name says which, as for `hil run --record`, and `.html` is the report,
/// `.json` the summary. What was there goes if it is an earlier record of the kind, or with `force`.
///
/// # Errors
/// [`Failure::Input`] for another ending or a file of another kind, [`Failure::Write`] for one that cannot be written.
pub fn save(path: &Path, setup: &Setup, outcome: &Outcome, force: bool) -> Result<(), Failure> {
    let format = match Format::of_name(path) {
        Some(whole @ (Format::Html | Format::Json)) => whole,
        _ => format_of_record(path)?,
    };
    let outputs = Outputs::new(force);
    check(outputs, (format, path), setup)?;
    write(format, path, setup, outcome)
}
