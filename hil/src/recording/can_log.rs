//! Recordings of CAN buses: logs in the format of can-utils' `candump -l`, in and out, and MCAP files, in.

use std::io::{self, Write};
use std::path::Path;

use palpate_core::bus::Received;
use palpate_core::units::Instant;
use palpate_records::{candump, mcap};

use palpate_files::FileError;

/// Frames of a recorded bus.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct CanRecording {
    /// In the order of the file.
    pub frames: Vec<Received>,
    /// The interfaces, bus by bus.
    pub interfaces: Vec<String>,
    /// What is to be said of the file: that it was cut short, and where.
    pub notes: Vec<String>,
}

/// Whether a recording is one of buses, by its name: a candump log or an MCAP file.
#[must_use]
pub fn is_can_recording(path: &Path) -> bool {
    path.extension()
        .is_some_and(|ending| ending == "log" || ending == "mcap")
}

/// Reads a log or an MCAP file of at most `buses` buses. The interfaces of a log in the order of their names
/// are buses 0, 1, ...; time zero is the whole second of the first frame, so that a log of ours keeps its times
/// and one of a wall clock starts within its first second. An MCAP file of a run says its buses and times
/// itself. A file that was cut short gives what it holds, with a note.
///
/// # Errors
/// An unreadable file, the first malformed line, no classic data frame, or more buses than that.
pub fn read_can_recording(path: &Path, buses: usize) -> Result<CanRecording, FileError> {
    let label = path.display().to_string();
    let bytes = std::fs::read(path)
        .map_err(|e| FileError::whole(&label, "a readable recording", e.to_string()))?;
    if path.extension().is_some_and(|ending| ending == "mcap") {
        return parse_mcap(&label, &bytes, buses);
    }
    let text = String::from_utf8(bytes).map_err(|e| FileError {
        line: Some(
            1 + e.as_bytes()[..e.utf8_error().valid_up_to()]
                .iter()
                .filter(|b| **b == b'\n')
                .count(),
        ),
        ..FileError::whole(&label, "a candump log", "bytes that are no text")
    })?;
    parse(&label, &text, buses)
}

fn too_many(label: &str, buses: usize, found: String) -> FileError {
    let expected = format!("at most {buses} interfaces, as the layout has buses");
    FileError::whole(label, expected, found)
}

/// Whole seconds of the first frame are none of a run's business.
fn from_first_second(frames: &mut [Received]) {
    let first = frames.iter().map(|r| r.at.as_micros()).min();
    let zero = first.map_or(0, |us| us - us % 1_000_000);
    for received in frames {
        received.at = Instant::from_micros(received.at.as_micros() - zero);
    }
}

fn parse_mcap(label: &str, bytes: &[u8], buses: usize) -> Result<CanRecording, FileError> {
    let read = mcap::read(bytes).map_err(|e| FileError::whole(label, e.expected, e.found))?;
    let mut notes = Vec::new();
    if !read.damages.is_empty() {
        let damages: Vec<_> = read
            .damages
            .iter()
            .take(4)
            .map(ToString::to_string)
            .collect();
        notes.push(format!(
            "{label}: {}; read {} messages, {} of them CAN frames, until {:.3} s",
            damages.join("; "),
            read.messages,
            read.frames.len(),
            read.last_ns as f64 * 1e-9
        ));
    }
    let mut frames = read.frames;
    let Some(highest) = frames.iter().map(|r| usize::from(r.bus)).max() else {
        let expected = "frames on the topic /can";
        let found = notes.pop().unwrap_or_else(|| "none".into());
        return Err(FileError::whole(label, expected, found));
    };
    let interfaces: Vec<String> = match read.metadata.get("interfaces") {
        Some(names) => names.split(',').map(str::to_owned).collect(),
        None => (0..=highest).map(|bus| format!("can{bus}")).collect(),
    };
    if highest >= buses {
        let found = format!("{}: {}", highest + 1, interfaces.join(", "));
        return Err(too_many(label, buses, found));
    }
    if !read.metadata.contains_key("scene") {
        from_first_second(&mut frames);
    }
    Ok(CanRecording {
        frames,
        interfaces,
        notes,
    })
}

fn parse(label: &str, text: &str, buses: usize) -> Result<CanRecording, FileError> {
    let log = candump::read(text).map_err(|error| FileError {
        path: label.into(),
        line: Some(error.line),
        key: None,
        expected: error.expected.into(),
        found: format!("`{}`{}", shown(text, error.line), after(error.before)),
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
        return Err(too_many(label, buses, found));
    }
    let received = |l: &candump::Logged| {
        Some(Received {
            at: l.at,
            bus: names.iter().position(|name| *name == l.interface)? as u8,
            frame: l.frame,
        })
    };
    let mut frames: Vec<Received> = log.frames.iter().filter_map(received).collect();
    from_first_second(&mut frames);
    let note = |line| {
        let count = frames.len();
        format!(
            "{label}:{line}: the log is cut short in this line; read the {count} frames before it"
        )
    };
    Ok(CanRecording {
        interfaces: names.iter().map(|n| (*n).to_owned()).collect(),
        notes: log.cut.map(note).into_iter().collect(),
        frames,
    })
}

/// What was whole before a malformed line.
fn after(frames: usize) -> String {
    match frames {
        0 => String::new(),
        n => format!(" after {n} whole frames"),
    }
}

/// The start of a line, for an error that shows it.
fn shown(text: &str, line: usize) -> String {
    let line = text.lines().nth(line - 1).unwrap_or_default();
    line.chars().take(60).collect()
}

/// Writes frames as a log; bus n is the n-th of these interfaces, and `can<n>` beyond them.
///
/// # Errors
/// What the system says of the file.
pub fn write_can_log(
    frames: &[Received],
    interfaces: &[String],
    out: &mut dyn Write,
) -> io::Result<()> {
    let highest = frames.iter().map(|r| usize::from(r.bus) + 1).max();
    let named = |bus: usize| {
        let name = interfaces.get(bus).cloned();
        name.unwrap_or_else(|| format!("can{bus}"))
    };
    let names: Vec<String> = (0..highest.unwrap_or(0)).map(named).collect();
    let mut lines = String::new();
    for received in frames {
        let interface = &names[usize::from(received.bus)];
        candump::write_line(&mut lines, received.at, interface, &received.frame);
        if lines.len() > 1 << 16 {
            out.write_all(lines.as_bytes())?;
            lines.clear();
        }
    }
    out.write_all(lines.as_bytes())?;
    Ok(())
}

#[cfg(test)]
#[path = "can_log_tests.rs"]
mod tests;
