//! One reading of a recording of buses, from its first frame to its last: a candump log or an MCAP file.

use std::fs::File;
use std::io::Read;
use std::path::Path;

use palpate_core::bus::Received;
use palpate_core::units::Instant;
use palpate_files::{
    FileError, Format, LONGEST_LINE, Lines, OutOfTime, Pace, Times, Unpacked, format_of,
    open_unpacked,
};
use palpate_records::{candump, mcap};
use palpate_run::Identifiers;

/// Expected kind of file, for errors.
const EXPECTED: &str = "a recording of buses, .log (candump) or .mcap";

fn too_many(label: &str, buses: usize, found: String) -> FileError {
    let expected = format!("at most {buses} interfaces, as the layout has buses");
    FileError::whole(label, expected, found)
}

/// Start of a run in a recording: its time zero, and the run's bus of each bus of the recording.
#[derive(Clone, Debug, Default)]
pub(super) struct Start {
    zero_us: u64,
    /// Bus of the run by the number of the recording's bus; empty: the same number.
    buses: Vec<u8>,
}

impl Start {
    pub(super) const fn time(&self, us: u64) -> Instant {
        Instant::from_micros(us.saturating_sub(self.zero_us))
    }

    pub(super) fn place(&self, received: &mut Received) {
        received.at = self.time(received.at.as_micros());
        let bus = self.buses.get(usize::from(received.bus));
        received.bus = bus.copied().unwrap_or(received.bus);
    }
}

/// Result of reading a recording through.
#[derive(Default)]
pub(super) struct Through {
    /// Frames of the recording, where they are few.
    pub(super) held: Option<Vec<Received>>,
    count: usize,
    pub(super) rows: Identifiers,
    first_us: Option<u64>,
    pub(super) newest_us: u64,
    highest: Option<u8>,
    pub(super) start: Start,
}

/// A recording that is read from its first frame to its last.
pub(super) enum Pass<R> {
    Log(Log<R>),
    Mcap(Mcap<R>),
}

impl Pass<File> {
    pub(super) fn open(path: &Path, split_jumps: bool) -> Result<Self, FileError> {
        let label = path.display().to_string();
        let times = Times::new(split_jumps);
        let is_mcap = match format_of(path) {
            Some(Format::Mcap) => true,
            Some(Format::Candump) => false,
            None => path.extension().is_some_and(|e| e == "mcap"),
            Some(format) => return Err(FileError::whole(label, EXPECTED, format.noun())),
        };
        if !is_mcap {
            let lines = Lines::open(path, EXPECTED, LONGEST_LINE)?;
            return Ok(Self::Log(Log::new(lines, times)));
        }
        let reader = mcap::McapReader::new(open_unpacked(path, EXPECTED)?);
        Ok(Self::Mcap(Mcap {
            reader: reader.map_err(|e| FileError::whole(&label, e.expected, e.found))?,
            label,
            times,
            count: 0,
        }))
    }
}

impl<R: Read> Pass<R> {
    /// The next frame in the order of the file, with the file's time and bus.
    pub(super) fn advance(&mut self) -> Result<Option<Received>, FileError> {
        match self {
            Self::Log(log) => log.advance(),
            Self::Mcap(mcap) => mcap.advance(),
        }
    }

    /// Reads all of it, and holds up to `most` frames. Returns the interfaces and the remarks on the file, too.
    pub(super) fn through(
        mut self,
        (buses, bitrate): (usize, u32),
        most: usize,
        is_stream: bool,
    ) -> Result<(Through, Vec<String>, Vec<String>), FileError> {
        let mut through = Through {
            held: Some(Vec::new()),
            ..Through::default()
        };
        let mut pace = Pace::new(bitrate);
        let cannot_be = |label: &str, found| {
            let expected = "times as frames came (candump -l, microseconds since 1970)";
            FileError::whole(label, expected, found)
        };
        while let Some(frame) = self.advance()? {
            let us = frame.at.as_micros();
            let of = (frame.bus, frame.frame.id(), frame.frame.data().len());
            let seen = pace.frame(of, us);
            seen.map_err(|found| cannot_be(self.label(), found))?;
            through.count += 1;
            through.rows.add(&frame);
            through.first_us = Some(through.first_us.map_or(us, |first| first.min(us)));
            through.newest_us = through.newest_us.max(us);
            through.highest = through.highest.max(Some(frame.bus));
            match &mut through.held {
                Some(held) if held.len() < most => held.push(frame),
                Some(_) if is_stream => {
                    return Err(FileError::whole(
                        self.label(),
                        format!("a pipe of at most {most} frames, which are held"),
                        "more (save it as a file, which is read as it is played)",
                    ));
                }
                held => *held = None,
            }
        }
        pace.end().map_err(|found| cannot_be(self.label(), found))?;
        let (interfaces, notes) = match self {
            Self::Log(log) => log.finish(&mut through, buses),
            Self::Mcap(mcap) => mcap.finish(&mut through, buses),
        }?;
        Ok((through, interfaces, notes))
    }

    fn label(&self) -> &str {
        match self {
            Self::Log(log) => log.lines.label(),
            Self::Mcap(mcap) => &mcap.label,
        }
    }
}

impl Through {
    /// Drops the whole seconds of the first frame's time.
    fn zero_at_first_second(&mut self) {
        self.start.zero_us = zero_of(self.first_us.unwrap_or(0));
    }
}

/// Time zero of a run whose first frame was recorded at this time.
pub(super) const fn zero_of(first_us: u64) -> u64 {
    first_us - first_us % 1_000_000
}

/// An MCAP file.
pub(super) struct Mcap<R> {
    label: String,
    reader: mcap::McapReader<Unpacked<R>>,
    times: Times,
    count: usize,
}

impl<R: Read> Mcap<R> {
    fn advance(&mut self) -> Result<Option<Received>, FileError> {
        let refused =
            |label: &str, e: mcap::Unreadable| FileError::whole(label, e.expected, e.found);
        let next = self.reader.advance();
        let Some(mut frame) = next.map_err(|e| refused(&self.label, e))? else {
            return Ok(None);
        };
        self.count += 1;
        let us = frame.at.as_micros();
        let place = format_args!("{}: frame {}", self.label, self.count).to_string();
        let bus = usize::from(frame.bus);
        let time = (self.times).frame_of(&place, (bus, format_args!("bus {bus}")), us);
        let time = time.map_err(|e| {
            let found = e.found.unwrap_or_else(|| format!("{us} us"));
            FileError::whole(
                &self.label,
                e.expected,
                format!("frame {}: {found}", self.count),
            )
        })?;
        frame.at = Instant::from_micros(time);
        Ok(Some(frame))
    }

    fn finish(
        mut self,
        through: &mut Through,
        buses: usize,
    ) -> Result<(Vec<String>, Vec<String>), FileError> {
        let label = self.label;
        let read = self.reader.into_read();
        let read = read.map_err(|e| FileError::whole(&label, e.expected, e.found))?;
        let mut notes = self.times.take_notes();
        if !read.damages.is_empty() {
            let damages = read.damages.iter().take(4).map(ToString::to_string);
            notes.push(format!(
                "{label}: {}; read {} messages, {} of them CAN frames, until {:.3} s",
                damages.collect::<Vec<_>>().join("; "),
                read.messages,
                through.count,
                read.last_ns as f64 * 1e-9
            ));
        }
        let Some(highest) = through.highest.map(usize::from) else {
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
            return Err(too_many(&label, buses, found));
        }
        if !read.metadata.contains_key("scene") {
            through.zero_at_first_second();
        }
        Ok((interfaces, notes))
    }
}

/// A log of candump; its buses are numbered as they come.
pub(super) struct Log<R> {
    lines: Lines<R>,
    times: Times,
    names: Vec<String>,
    count: usize,
    beside: candump::Beside,
    /// A malformed line, which is a cut one if none follows.
    cut: Option<(bool, FileError)>,
}

impl<R: Read> Log<R> {
    pub(super) fn new(lines: Lines<R>, times: Times) -> Self {
        Self {
            lines,
            times,
            names: Vec::new(),
            count: 0,
            beside: candump::Beside::default(),
            cut: None,
        }
    }

    fn advance(&mut self) -> Result<Option<Received>, FileError> {
        let label = self.lines.label().to_owned();
        while let Some((number, line)) = self.lines.advance()? {
            if line.trim().is_empty() {
                continue;
            }
            if let Some((_, error)) = self.cut.take() {
                return Err(error);
            }
            match candump::read_line(line) {
                Ok(candump::Line::Frame(logged)) => {
                    let us = logged.at.as_micros();
                    let known = self.names.iter().position(|n| *n == logged.interface);
                    let bus = known.unwrap_or_else(|| {
                        self.names.push(logged.interface);
                        self.names.len() - 1
                    });
                    let Ok(bus) = u8::try_from(bus) else {
                        return Err(too_many(&label, 256, "more".into()));
                    };
                    let named = (usize::from(bus), self.names[usize::from(bus)].as_str());
                    let time = self.times.frame_of(&format!("{label}:{number}"), named, us);
                    let time = time.map_err(|e| out_of_time(&label, number, us, e))?;
                    self.count += 1;
                    return Ok(Some(Received {
                        at: Instant::from_micros(time),
                        bus,
                        frame: logged.frame,
                    }));
                }
                Ok(candump::Line::Beside(beside)) => self.beside.add(beside),
                Err(expected) => {
                    let error = malformed(&label, number, (expected, line), self.count);
                    let is_cut = candump::is_cut(line) && self.count > 0;
                    self.cut = Some((is_cut && self.lines.is_unfinished(), error));
                }
            }
        }
        match self.cut.take() {
            Some((false, error)) => Err(error),
            cut => {
                self.cut = cut;
                Ok(None)
            }
        }
    }

    fn finish(
        mut self,
        through: &mut Through,
        buses: usize,
    ) -> Result<(Vec<String>, Vec<String>), FileError> {
        let label = self.lines.label();
        let mut notes = self.times.take_notes();
        notes.extend(self.lines.note());
        if let Some((_, error)) = self.cut {
            notes.push(format!(
                "{label}:{}: the log is cut short in this line; read the {} frames before it",
                error.line.unwrap_or(0),
                self.count
            ));
        }
        let beside = self.beside.words();
        if self.names.is_empty() {
            let found = beside.map_or("none".into(), |words| format!("none: {words}"));
            let expected = "classic data frames with 11-bit identifiers";
            return Err(FileError::whole(label, expected, found));
        }
        if self.names.len() > buses {
            let found = format!("{}: {}", self.names.len(), self.names.join(", "));
            return Err(too_many(label, buses, found));
        }
        notes.extend(beside.map(|words| format!("{label}: {words}")));
        let mut interfaces = self.names.clone();
        interfaces.sort_unstable_by(|a, b| (a.len(), a).cmp(&(b.len(), b))); // can2 before can10
        let bus = |name| interfaces.iter().position(|i| i == name).unwrap_or(0);
        through.start.buses = self.names.iter().map(|name| bus(name) as u8).collect(); // at most 256
        through.zero_at_first_second();
        Ok((interfaces, notes))
    }
}

fn out_of_time(label: &str, line: usize, us: u64, e: OutOfTime) -> FileError {
    let found = e.found.unwrap_or_else(|| format!("{us} us"));
    FileError {
        line: Some(line),
        ..FileError::whole(label, e.expected, found)
    }
}

/// Error for a malformed line, behind so many frames.
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

/// Words on the whole frames before a malformed line.
fn after(frames: usize) -> String {
    match frames {
        0 => String::new(),
        n => format!(" after {n} whole frames"),
    }
}
