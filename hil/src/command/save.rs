//! A record of a run that is over, for other programs than `hil` itself.

use std::path::Path;

use palpate_files::Setup;
use palpate_run::{Failure, Outcome};

use super::run_files::Format;
use crate::output::Outputs;

/// Writes one record of a run; the ending of the name says which, as for `hil run --record`, and `.html` is the report,
/// `.json` the summary. What was there goes if it is an earlier record of the kind, or with `force`.
///
/// # Errors
/// [`Failure::Input`] for another ending or a file of another kind, [`Failure::Write`] for one that cannot be written.
pub fn save(path: &Path, setup: &Setup, outcome: &Outcome, force: bool) -> Result<(), Failure> {
    let format = match path.extension().and_then(|ending| ending.to_str()) {
        Some("html") => Format::Report,
        Some("json") => Format::Summary,
        _ => Format::of(path)?,
    };
    let outputs = Outputs { force, inputs: &[] };
    match format {
        Format::Contacts => outputs.check_table(path)?,
        format => {
            let paths = format.paths(path, setup);
            let mut each = paths.iter();
            each.try_for_each(|path| outputs.check(path, format.on_disk()))?;
        }
    }
    format.write(path, setup, outcome)
}
