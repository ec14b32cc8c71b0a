//! Two recordings of contacts, read side by side and compared.

use std::fs::File;

use palpate_files::{FileError, Lines};
use palpate_records::diff::{Contacts, Difference, Tolerance, compare_contacts};
use palpate_run::damaged;

/// Compares the contacts of two tables, moment by moment.
///
/// # Errors
/// A file that cannot be read, and the first line that is no contact.
pub fn compare_recordings(
    a: &mut Lines<File>,
    b: &mut Lines<File>,
    tolerance: Tolerance,
) -> Result<Vec<Difference>, FileError> {
    compare_contacts(&mut reader(a)?, &mut reader(b)?, tolerance)
}

fn reader(lines: &mut Lines<File>) -> Result<Contacts<'_, FileError>, FileError> {
    let label = lines.label().to_owned();
    let next = || Ok(lines.advance()?.map(|(_, line)| line.to_owned()));
    Contacts::new(next, move |damage| damaged(&label, damage))
}
