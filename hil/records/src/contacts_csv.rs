//! Contacts as CSV: `frame,time_us,module,contact,x_mm,y_mm,intensity,level,members`, and with several displays
//! `display`, the one that the module belongs to.

use crate::fixed::{milli, milli_u};
use crate::trace::{DisplayInfo, Trace, event};
use std::io::{self, Write};

/// First line of the file.
pub const HEADER: &str = "frame,time_us,module,contact,x_mm,y_mm,intensity,level,members";

/// The column that tables of several displays have after those of [`HEADER`].
pub const DISPLAY: &str = "display";

/// Writes every contact of a run, in their order; millimetres and raw counts with three decimals.
///
/// # Errors
/// Whatever the writer says.
pub fn write_table(trace: &Trace, mut out: impl Write) -> io::Result<()> {
    match trace.header.displays.as_slice() {
        [] => writeln!(out, "{HEADER}")?,
        _ => writeln!(out, "{HEADER},{DISPLAY}")?,
    }
    rows(trace.each(), &trace.header.displays, out)
}

/// Writes the rows alone, of a run with one display.
///
/// # Errors
/// Whatever the writer says.
pub fn write_rows<'a>(
    contacts: impl IntoIterator<Item = &'a event::Contact>,
    out: impl Write,
) -> io::Result<()> {
    rows(contacts, &[], out)
}

/// The name of the display that a module belongs to, as a field.
fn display_of(displays: &[DisplayInfo], module: u16) -> String {
    let own = displays.iter().find(|d| d.modules.contains(&module));
    let name = own.map_or("", |d| d.name.as_str());
    match name.contains([',', '"', '\n', '\r']) {
        true => format!("\"{}\"", name.replace('"', "\"\"")),
        false => name.to_owned(),
    }
}

fn rows<'a>(
    contacts: impl IntoIterator<Item = &'a event::Contact>,
    displays: &[DisplayInfo],
    mut out: impl Write,
) -> io::Result<()> {
    for c in contacts {
        let (x, y) = (milli(c.place.x.into()), milli(c.place.y.into()));
        let intensity = milli_u(c.intensity_milli.into());
        write!(
            out,
            "{},{},{},{},{x},{y},{intensity},{},{}",
            c.frame, c.t_us, c.module, c.contact, c.level, c.members
        )?;
        match displays {
            [] => writeln!(out)?,
            several => writeln!(out, ",{}", display_of(several, c.module))?,
        }
    }
    Ok(())
}

#[cfg(test)]
#[path = "contacts_csv_tests.rs"]
mod tests;
