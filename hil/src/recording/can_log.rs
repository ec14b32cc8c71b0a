//! Recordings of CAN buses: logs in the format of can-utils' `candump -l`, in and out, and MCAP files, in.

use std::io::{self, BufReader, Read, Write};
use std::path::Path;

use palpate_core::bus::Received;
use palpate_core::units::Instant;
use palpate_records::{candump, mcap};

use palpate_files::{FileError, Format, Lines, OutOfTime, Times, format_of, open};

use crate::progress::Progress;

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

/// Most frames of a recording that a run holds, 24 bytes each.
const MOST_FRAMES: usize = 8 << 20;
/// Longest line of a log, bytes: that of a CAN FD frame has 170.
const LONGEST: usize = 4096;

/// Whether a recording is one of buses: a candump log or an MCAP file by its first bytes, or, where they say nothing,
/// by its name.
#[must_use]
pub fn is_can_recording(path: &Path) -> bool {
    let named = || {
        path.extension()
            .is_some_and(|ending| ending == "log" || ending == "mcap")
    };
    match format_of(path) {
        Some(format) => matches!(format, Format::Candump | Format::Mcap),
        None => named(),
    }
}

/// Reads a log or an MCAP file of at most `buses` buses. The interfaces of a log in the order of their names
/// are buses 0, 1, ...; time zero is the whole second of the first frame, so that a log of ours keeps its times
/// and one of a wall clock starts within its first second. An MCAP file of a run says its buses and times
/// itself. A file that was cut short gives what it holds, with a note. Jumps of the clock are taken out where
/// `split_jumps` says so.
///
/// # Errors
/// An unreadable file, the first malformed line, a jump of the clock, no classic data frame, more buses than that, or
/// more than 8 million frames.
pub fn read_can_recording(
    path: &Path,
    buses: usize,
    split_jumps: bool,
) -> Result<CanRecording, FileError> {
    let label = path.display().to_string();
    let times = Times::new(split_jumps);
    let _shown = Progress::reading(path);
    match format_of(path) {
        Some(Format::Mcap) => parse_mcap(&label, open(path, EXPECTED)?, buses, times),
        None if path.extension().is_some_and(|e| e == "mcap") => {
            parse_mcap(&label, open(path, EXPECTED)?, buses, times)
        }
        Some(Format::Candump) | None => parse(Lines::open(path, EXPECTED, LONGEST)?, buses, times),
        Some(format) => Err(FileError::whole(label, EXPECTED, format.noun())),
    }
}

/// What this reads, for errors.
const EXPECTED: &str = "a recording of buses, .log (candump) or .mcap";

fn too_many(label: &str, buses: usize, found: String) -> FileError {
    let expected = format!("at most {buses} interfaces, as the layout has buses");
    FileError::whole(label, expected, found)
}

fn too_long(label: &str) -> FileError {
    let expected = format!("at most {MOST_FRAMES} frames");
    FileError::whole(label, expected, "more (cut the recording)")
}

/// Whole seconds of the first frame are none of a run's business.
fn from_first_second(frames: &mut [Received]) {
    let first = frames.iter().map(|r| r.at.as_micros()).min();
    let zero = first.map_or(0, |us| us - us % 1_000_000);
    for received in frames {
        received.at = Instant::from_micros(received.at.as_micros() - zero);
    }
}

fn parse_mcap(
    label: &str,
    file: impl Read,
    buses: usize,
    mut times: Times,
) -> Result<CanRecording, FileError> {
    let mut frames: Vec<Received> = Vec::new();
    let mut take = |mut frame: Received| {
        let refused = |expected: String, found: String| mcap::Unreadable { expected, found };
        if frames.len() == MOST_FRAMES {
            let error = too_long(label);
            return Err(refused(error.expected, error.found));
        }
        let us = frame.at.as_micros();
        let place = format!("{label}: frame {}", frames.len() + 1);
        let time = times.frame(&place, us).map_err(|e| {
            let found = e.found.unwrap_or_else(|| format!("{us} us"));
            refused(e.expected, format!("frame {}: {found}", frames.len() + 1))
        })?;
        frame.at = Instant::from_micros(time);
        frames.push(frame);
        Ok(())
    };
    let read = mcap::read_from(BufReader::new(file), &mut take)
        .map_err(|e| FileError::whole(label, e.expected, e.found))?;
    let mut notes = times.take_notes();
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
            frames.len(),
            read.last_ns as f64 * 1e-9
        ));
    }
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

fn parse<R: Read>(
    mut lines: Lines<R>,
    buses: usize,
    mut times: Times,
) -> Result<CanRecording, FileError> {
    let label = lines.label().to_owned();
    let (mut frames, mut names, mut other_kinds) = (Vec::new(), Vec::<String>::new(), 0);
    // A malformed line, which is a cut one if none follows.
    let mut cut: Option<(bool, FileError)> = None;
    while let Some((number, line)) = lines.advance()? {
        if line.trim().is_empty() {
            continue;
        }
        if let Some((_, error)) = cut {
            return Err(error);
        }
        match candump::read_line(line) {
            Ok(Some(logged)) => {
                let place = format!("{label}:{number}");
                let us = logged.at.as_micros();
                let time = times.frame(&place, us);
                let time = time.map_err(|e| out_of_time(&label, number, us, e))?;
                let known = names.iter().position(|name| *name == logged.interface);
                let bus = known.unwrap_or_else(|| {
                    names.push(logged.interface);
                    names.len() - 1
                });
                if frames.len() == MOST_FRAMES {
                    return Err(too_long(&label));
                }
                frames.push(Received {
                    at: Instant::from_micros(time),
                    bus: u8::try_from(bus).unwrap_or(u8::MAX), // more than that are refused below
                    frame: logged.frame,
                });
            }
            Ok(None) => other_kinds += 1,
            Err(expected) => {
                let error = malformed(&label, number, (expected, line), frames.len());
                let is_cut = candump::is_cut(line) && !frames.is_empty();
                cut = Some((is_cut && lines.is_unfinished(), error));
            }
        }
    }
    let mut notes = times.take_notes();
    notes.extend(lines.note());
    match cut {
        Some((true, error)) => notes.push(format!(
            "{label}:{}: the log is cut short in this line; read the {} frames before it",
            error.line.unwrap_or(0),
            frames.len()
        )),
        Some((false, error)) => return Err(error),
        None => {}
    }
    if names.is_empty() {
        let found = format!("none, and {other_kinds} of another kind");
        let expected = "classic data frames with 11-bit identifiers";
        return Err(FileError::whole(label, expected, found));
    }
    if names.len() > buses {
        let found = format!("{}: {}", names.len(), names.join(", "));
        return Err(too_many(&label, buses, found));
    }
    let mut interfaces = names.clone();
    interfaces.sort_unstable_by(|a, b| (a.len(), a).cmp(&(b.len(), b))); // can2 before can10
    for received in &mut frames {
        let name = names.get(usize::from(received.bus));
        let bus = interfaces.iter().position(|i| Some(i) == name);
        received.bus = bus.unwrap_or(0) as u8; // at most as many as buses
    }
    from_first_second(&mut frames);
    Ok(CanRecording {
        frames,
        interfaces,
        notes,
    })
}

fn out_of_time(label: &str, line: usize, us: u64, e: OutOfTime) -> FileError {
    let found = e.found.unwrap_or_else(|| format!("{us} us"));
    FileError {
        line: Some(line),
        ..FileError::whole(label, e.expected, found)
    }
}

/// A line that is not what was expected, behind so many frames.
fn malformed(
    label: &str,
    number: usize,
    (expected, line): (&str, &str),
    frames: usize,
) -> FileError {
    let shown: String = line.chars().take(60).collect();
    FileError {
        line: Some(number),
        ..FileError::whole(label, expected, format!("`{shown}`{}", after(frames)))
    }
}

/// What was whole before a malformed line.
fn after(frames: usize) -> String {
    match frames {
        0 => String::new(),
        n => format!(" after {n} whole frames"),
    }
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
