//! Contacts as CSV: `frame,time_us,module,contact,x_mm,y_mm,intensity,level,members`, and with several displays
//! `display`, the one that the module belongs to.

use crate::fixed::{milli, milli_u};
use crate::table::as_csv;
use crate::trace::{DisplayInfo, Trace, event};
use std::io::{self, Write};

/// First line of the file.
pub const HEADER: &str = "frame,time_us,module,contact,x_mm,y_mm,intensity,level,members";

/// The column that tables of several displays have after those of [`HEADER`].
pub const DISPLAY: &str = "display";

/// Contacts whose rows are text at one time.
const CHUNK: usize = 4096;

/// Writes every contact of a run, in their order; millimetres and raw counts with three decimals.
///
/// # Errors
/// The writer's error.
pub fn write_table(trace: &Trace, out: &mut dyn Write) -> io::Result<()> {
    let displays = &trace.header.displays;
    write_header(displays, out)?;
    write_rows(trace.each(), displays, out)
}

/// Writes the first line, of a run with these displays where they are several.
///
/// # Errors
/// The writer's error.
pub fn write_header(displays: &[DisplayInfo], out: &mut dyn Write) -> io::Result<()> {
    match displays {
        [] => writeln!(out, "{HEADER}"),
        _ => writeln!(out, "{HEADER},{DISPLAY}"),
    }
}

/// The name of the display that a module belongs to.
fn display_of(displays: &[DisplayInfo], module: u16) -> &str {
    let own = displays.iter().find(|d| d.modules.contains(&module));
    own.map_or("", |d| d.name.as_str())
}

/// Writes rows below [`write_header`] with the same displays.
///
/// # Errors
/// The writer's error.
pub fn write_rows<'a>(
    contacts: impl IntoIterator<Item = &'a event::Contact>,
    displays: &[DisplayInfo],
    out: &mut dyn Write,
) -> io::Result<()> {
    let mut contacts = contacts.into_iter().peekable();
    while contacts.peek().is_some() {
        let chunk: Vec<&event::Contact> = contacts.by_ref().take(CHUNK).collect();
        out.write_all(text(&chunk, displays).as_bytes())?;
    }
    Ok(())
}

/// Rows as text, compiled once for all sources of contacts.
fn text(contacts: &[&event::Contact], displays: &[DisplayInfo]) -> String {
    as_csv(contacts.iter().map(|c| {
        let place = [c.place.x, c.place.y].map(|um| milli(i64::from(um)));
        let intensity = milli_u(u64::from(c.intensity_milli));
        let display = (!displays.is_empty()).then(|| display_of(displays, c.module));
        (
            (c.frame, c.t_us, c.module, c.contact),
            (place, intensity, c.level, c.members),
            Vec::from_iter(display),
        )
    }))
}

#[cfg(test)]
#[path = "contacts_csv_tests.rs"]
mod tests;
