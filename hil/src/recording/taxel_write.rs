//! Readings as a recording: the CSV that [`super::read_taxel_csv`] reads.

use std::io::{self, Write};

use palpate_run::TaxelTable;

use palpate_files::Columns;

/// Writes a table with its times.
///
/// # Errors
/// What the stream says.
pub fn write_taxel_csv(
    table: &TaxelTable,
    columns: &Columns,
    out: &mut dyn Write,
) -> io::Result<()> {
    write!(out, "time_us")?;
    for index in 0..table.columns {
        write!(out, ",{}", columns.name(index))?;
    }
    writeln!(out)?;
    for (row, time) in table.time_us.iter().enumerate() {
        write!(out, "{time}")?;
        for count in table.frame(row).unwrap_or_default() {
            write!(out, ",{count}")?;
        }
        writeln!(out)?;
    }
    Ok(())
}

#[cfg(test)]
#[path = "taxel_write_tests.rs"]
mod tests;
