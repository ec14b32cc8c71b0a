//! Writer of readings as a recording: the CSV that [`super::read_taxel_csv`] reads.

use std::io::{self, Write};

use palpate_run::TaxelTable;

use palpate_files::{Columns, JOINT, Joint};

/// Writes a table with its times, and the angles of joints at them.
///
/// # Errors
/// Errors of the stream.
pub fn write_taxel_csv(
    table: &TaxelTable,
    columns: &Columns,
    joints: &[Joint],
    out: &mut dyn Write,
) -> io::Result<()> {
    write!(out, "time_us")?;
    for index in 0..table.columns {
        write!(out, ",{}", columns.name(index))?;
    }
    for joint in joints {
        write!(out, ",{JOINT}{}", joint.name)?;
    }
    writeln!(out)?;
    for (row, time) in table.time_us.iter().enumerate() {
        write!(out, "{time}")?;
        for count in table.frame(row).unwrap_or_default() {
            write!(out, ",{count}")?;
        }
        for joint in joints {
            write!(out, ",{:.3}", joint.at(*time as f64 * 1e-6))?;
        }
        writeln!(out)?;
    }
    Ok(())
}

#[cfg(test)]
#[path = "taxel_write_tests.rs"]
mod tests;
