//! Logs of a CAN bus in the format of can-utils' `candump -l`, in and out.

use std::io::{self, Write};
use std::path::Path;

use palpate_core::bus::Received;
use palpate_core::units::Instant;
use palpate_records::candump;

use super::FileError;

/// Whether a recording is a log by its name.
#[must_use]
pub fn is_can_log(path: &Path) -> bool {
    path.extension().is_some_and(|ending| ending == "log")
}

/// Reads a log of at most `buses` interfaces. The interfaces in the order of their names are buses 0, 1, ...;
/// time zero is the whole second of the first frame, so that a log of ours keeps its times and one of a
/// wall clock starts within its first second.
///
/// # Errors
/// An unreadable file, the first malformed line, no classic data frame, or more interfaces than buses.
pub fn read_can_log(path: &Path, buses: usize) -> Result<Vec<Received>, FileError> {
    let label = path.display().to_string();
    let text = std::fs::read_to_string(path)
        .map_err(|e| FileError::whole(&label, "a readable candump log", e.to_string()))?;
    parse(&label, &text, buses)
}

fn parse(label: &str, text: &str, buses: usize) -> Result<Vec<Received>, FileError> {
    let log = candump::read(text).map_err(|error| FileError {
        path: label.into(),
        line: Some(error.line),
        key: None,
        expected: error.expected.into(),
        found: format!("`{}`", shown(text, error.line)),
    })?;
    let mut names: Vec<&str> = log.frames.iter().map(|l| l.interface.as_str()).collect();
    names.sort_unstable_by_key(|name| (name.len(), *name)); // can2 before can10
    names.dedup();
    if names.is_empty() {
        let found = format!("none, and {} of another kind", log.other_kinds);
        let expected = "classic data frames with 11-bit identifiers";
        return Err(FileError::whole(label, expected, found));
    }
    if names.len() > buses {
        let found = format!("{}: {}", names.len(), names.join(", "));
        let expected = format!("at most {buses} interfaces, as the layout has buses");
        return Err(FileError::whole(label, expected, found));
    }
    let first = log.frames.iter().map(|l| l.at.as_micros()).min();
    let zero = first.map_or(0, |us| us - us % 1_000_000);
    let received = |l: &candump::Logged| {
        Some(Received {
            at: Instant::from_micros(l.at.as_micros() - zero),
            bus: names.iter().position(|name| *name == l.interface)? as u8,
            frame: l.frame,
        })
    };
    Ok(log.frames.iter().filter_map(received).collect())
}

/// The start of a line, for an error that shows it.
fn shown(text: &str, line: usize) -> String {
    let line = text.lines().nth(line - 1).unwrap_or_default();
    line.chars().take(60).collect()
}

/// Writes frames as a log; bus n is interface `can<n>`, times are microseconds since the start of the run.
///
/// # Errors
/// What the system says of the file.
pub fn write_can_log(frames: &[Received], out: &mut dyn Write) -> io::Result<()> {
    let mut line = String::new();
    for received in frames {
        line.clear();
        let interface = format!("can{}", received.bus);
        candump::write_line(&mut line, received.at, &interface, &received.frame);
        out.write_all(line.as_bytes())?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_log_of_a_wall_clock_starts_within_its_first_second_and_buses_go_by_name() {
        let text =
            "(1436509052.249713) can10 104#938406805591BB0C\n(1436509053.000001) can2 004#00 R\n";
        let frames = parse("a.log", text, 2).unwrap();
        let seen: Vec<_> = frames.iter().map(|r| (r.at.as_micros(), r.bus)).collect();
        assert_eq!(seen, [(249_713, 1), (1_000_001, 0)]);
    }

    #[test]
    fn what_was_written_is_read_again() {
        let text =
            "(0000000000.000116) can0 104#938406805591BB0C\n(0000000003.000000) can1 20F#0700\n";
        let mut again = Vec::new();
        write_can_log(&parse("a.log", text, 2).unwrap(), &mut again).unwrap();
        assert_eq!(String::from_utf8(again).unwrap(), text);
    }

    #[test]
    fn bad_logs_are_named_with_their_line() {
        let told = |text, buses| parse("a.log", text, buses).unwrap_err().to_string();
        assert_eq!(
            told("(1.000000) can0 104#00\nhello", 1),
            "a.log:2: expected `(seconds.microseconds) interface id#data`, found `hello`"
        );
        assert_eq!(
            told("(1.000000) can0 104#00\n(1.000000) can1 104#00", 1),
            "a.log: expected at most 1 interfaces, as the layout has buses, found 2: can0, can1"
        );
        assert_eq!(
            told("(1.000000) can0 104#R\n", 1),
            "a.log: expected classic data frames with 11-bit identifiers, found none, and 1 of another kind"
        );
    }
}
