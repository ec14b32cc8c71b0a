//! Recordings of CAN buses: logs in the format of can-utils' `candump -l`, in and out, and MCAP files, in.
//!
//! A recording is read through once, for its health, its buses and its begin. A short one is held from then on, a long
//! one is read again for every pass, with the frames of its last second in memory.

use std::collections::BTreeMap;
use std::io::{self, Read, Write};
use std::path::{Path, PathBuf};
use std::sync::Arc;

use palpate_core::bus::Received;
use palpate_core::units::Instant;
use palpate_records::candump;

use palpate_files::{DISORDER_US, FileError, Format, format_of, holds_frames, is_stream};
use palpate_run::{CanFrames, Failure, FrameSource, Frames};

use super::pass::{Pass, Start, Through};

use crate::progress::Progress;

/// Frames of a recorded bus.
#[derive(Clone, Debug)]
pub struct CanRecording {
    /// Frames, the oldest first.
    pub frames: Arc<dyn FrameSource>,
    /// The interfaces, bus by bus.
    pub interfaces: Vec<String>,
    /// Remarks on the file: that it was cut short, and where.
    pub notes: Vec<String>,
}

/// Most frames of a file that are held, 24 bytes each; of a stream, which can be read only once.
const HELD: usize = 1 << 18;
const HELD_OF_STREAM: usize = 4 << 20;

/// Tells whether a recording is one of buses: a candump log or an MCAP file by its first bytes, or, where they say
/// nothing, by its name.
#[must_use]
pub fn is_can_recording(path: &Path) -> bool {
    let named = || {
        path.extension()
            .is_some_and(|ending| ending == "log" || ending == "mcap")
    };
    match format_of(path) {
        // Others log skins as messages of their own.
        Some(Format::Mcap) => holds_frames(path),
        Some(format) => format == Format::Candump,
        None => named(),
    }
}

/// Reads a log or an MCAP file of at most so many buses, which carry so many bits per second. The interfaces of a log in the order of their names
/// are buses 0, 1, ...; time zero is the whole second of the first frame, so that a log of ours keeps its times
/// and one of a wall clock starts within its first second. An MCAP file of a run says its buses and times
/// itself. A file that was cut short gives what it holds, with a note. Jumps of the clock are taken out where
/// `split_jumps` says so.
///
/// # Errors
/// An unreadable file, the first malformed line, a jump of the clock, no classic data frame, more buses than that, or
/// a stream of more than 4 million frames.
pub fn read_can_recording(
    path: &Path,
    buses: (usize, u32),
    split_jumps: bool,
) -> Result<CanRecording, FileError> {
    let _shown = Progress::reading(path);
    let pass = Pass::open(path, split_jumps)?;
    let (most, stream) = match is_stream(path) {
        true => (HELD_OF_STREAM, true),
        false => (HELD, false),
    };
    let (through, interfaces, notes) = pass.through(buses, most, stream)?;
    let Through {
        held, start, rows, ..
    } = through;
    let frames: Arc<dyn FrameSource> = match held {
        Some(mut frames) => {
            frames.iter_mut().for_each(|frame| start.place(frame));
            Arc::new(CanFrames::new(frames))
        }
        None => Arc::new(LongRecording {
            path: path.into(),
            split_jumps,
            rows: rows.most(),
            end: start.time(through.newest_us),
            start,
        }),
    };
    Ok(CanRecording {
        frames,
        interfaces,
        notes,
    })
}

/// A recording that was read through once, and is read again for every pass.
#[derive(Debug)]
struct LongRecording {
    path: PathBuf,
    split_jumps: bool,
    rows: usize,
    end: Instant,
    start: Start,
}

impl FrameSource for LongRecording {
    fn rows(&self) -> usize {
        self.rows
    }

    fn end(&self) -> Instant {
        self.end
    }

    fn frames(&self) -> Result<Frames<'_>, Failure> {
        Ok(Box::new(Ordered {
            pass: Pass::open(&self.path, self.split_jumps)?,
            start: &self.start,
            waiting: BTreeMap::new(),
            count: 0,
            newest_us: 0,
            ended: false,
        }))
    }
}

/// The frames of a pass, the oldest first: no frame comes later than [`DISORDER_US`] after its time.
struct Ordered<'a, R> {
    pass: Pass<R>,
    start: &'a Start,
    /// Frames that wait for earlier ones, by time and place in the file.
    waiting: BTreeMap<(u64, u64), Received>,
    count: u64,
    newest_us: u64,
    ended: bool,
}

impl<R: Read> Iterator for Ordered<'_, R> {
    type Item = Result<Received, Failure>;

    fn next(&mut self) -> Option<Self::Item> {
        loop {
            let is_due = |(us, _): &(u64, u64)| self.ended || us + DISORDER_US <= self.newest_us;
            if let Some(first) = self.waiting.first_entry().filter(|e| is_due(e.key())) {
                let mut frame = first.remove();
                self.start.place(&mut frame);
                return Some(Ok(frame));
            }
            if self.ended {
                return None;
            }
            match self.pass.advance() {
                Ok(Some(frame)) => {
                    let us = frame.at.as_micros();
                    self.newest_us = self.newest_us.max(us);
                    self.count += 1;
                    self.waiting.insert((us, self.count), frame);
                }
                Ok(None) => self.ended = true,
                Err(error) => {
                    self.ended = true;
                    self.waiting.clear();
                    return Some(Err(error.into()));
                }
            }
        }
    }
}

/// Writes frames as a log; bus n is the n-th of these interfaces, and `can<n>` beyond them.
///
/// # Errors
/// Error of the system on the file.
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
