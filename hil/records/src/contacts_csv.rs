//! Contacts as CSV: `frame,time_us,module,contact,x_mm,y_mm,intensity,level,members`.

use crate::fixed::{milli, milli_u};
use crate::trace::Event;
use std::io::{self, Write};

/// First line of the file.
pub const HEADER: &str = "frame,time_us,module,contact,x_mm,y_mm,intensity,level,members";

/// Writes every contact among the events, in their order; millimetres and raw counts with three decimals.
///
/// # Errors
/// Whatever the writer says.
pub fn write_table(events: &[Event], mut out: impl Write) -> io::Result<()> {
    writeln!(out, "{HEADER}")?;
    write_rows(events, out)
}

/// Writes the rows of events alone.
///
/// # Errors
/// Whatever the writer says.
pub fn write_rows(events: &[Event], mut out: impl Write) -> io::Result<()> {
    for event in events {
        if let Event::Contact {
            t_us,
            frame,
            module,
            contact,
            place,
            intensity_milli,
            level,
            members,
        } = event
        {
            let x = milli(i64::from(place.x));
            let y = milli(i64::from(place.y));
            let intensity = milli_u(u64::from(*intensity_milli));
            writeln!(
                out,
                "{frame},{t_us},{module},{contact},{x},{y},{intensity},{level},{members}"
            )?;
        }
    }
    Ok(())
}

#[cfg(test)]
#[path = "contacts_csv_tests.rs"]
mod tests;
