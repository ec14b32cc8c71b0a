//! Contacts as CSV: `frame,time_us,module,contact,x_mm,y_mm,intensity,level,members`.

use crate::fixed::{milli, milli_u};
use crate::trace::{Event, Trace};
use std::io::{self, Write};

/// First line of the file.
pub const HEADER: &str = "frame,time_us,module,contact,x_mm,y_mm,intensity,level,members";

/// Writes every contact of the trace, in its order; millimetres and raw counts with three decimals.
///
/// # Errors
/// Whatever the writer says.
pub fn write_contacts(trace: &Trace, mut out: impl Write) -> io::Result<()> {
    writeln!(out, "{HEADER}")?;
    write_rows(&trace.events, out)
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
mod tests {
    use super::*;
    use crate::synthetic;

    #[test]
    fn every_row_has_the_columns_of_the_header() {
        let trace = synthetic::circle(1);
        let mut out = Vec::new();
        write_contacts(&trace, &mut out).unwrap();
        let text = String::from_utf8(out).unwrap();
        let mut lines = text.lines();
        assert_eq!(lines.next(), Some(HEADER));
        let mut rows = 0;
        for line in lines {
            let fields: Vec<_> = line.split(',').collect();
            assert_eq!(fields.len(), 9, "{line}");
            assert!(fields[4].parse::<f64>().unwrap().abs() < 10.0);
            rows += 1;
        }
        let contacts = trace
            .events
            .iter()
            .filter(|e| matches!(e, Event::Contact { .. }));
        assert_eq!(rows, contacts.count());
    }
}
