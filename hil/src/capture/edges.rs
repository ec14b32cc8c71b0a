//! Signals as their edges, and how a VCD becomes them.

use std::cell::Cell;
use std::collections::BTreeMap;
use std::io::{self, BufRead, BufReader, Read};

use vcd::{Command, IdCode, Parser, TimescaleUnit, Value, VarType};

use super::{MOST_CHANGES, too_long};
use palpate_files::{FileError, LONGEST_LINE, Text};

/// A digital signal.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Signal {
    /// Name in the file.
    pub name: String,
    /// Changes of the signal, in the order of time: nanoseconds since
    /// the start of the capture, and the level after the change.
    pub edges: Vec<(u64, bool)>,
}

/// Capture of a logic analyser.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Capture {
    /// Digital signals of the capture.
    pub signals: Vec<Signal>,
    /// Resolution of its times, nanoseconds.
    pub resolution_ns: u64,
    /// Length of the capture, nanoseconds.
    pub end_ns: u64,
    /// Damages of the file, each with its line, and the part that could be read.
    pub notes: Vec<String>,
}

impl Signal {
    /// Sets the level at a time; false for the same level again, which is no edge.
    pub(super) fn set(&mut self, t_ns: u64, high: bool) -> bool {
        let now = self.edges.last().map(|e| e.1);
        let is_edge = now != Some(high) && (now.is_some() || high || t_ns == 0);
        if is_edge {
            self.edges.push((t_ns, high));
        }
        is_edge
    }

    /// Whole pulses: rise and width, nanoseconds. One that begins or ends outside of the capture counts if it has
    /// lasted `period_ns` by then, which no pulse does: the output is stuck.
    pub fn pulses(&self, end_ns: u64, period_ns: u64) -> Vec<(u64, u64)> {
        let ends = (self.edges.iter().skip(1).map(|e| (e.0, false))).chain([(end_ns, true)]);
        let high = self.edges.iter().zip(ends).filter(|(edge, _)| edge.1);
        let pulse = high.filter_map(|(edge, (end, cut))| {
            let width = end.saturating_sub(edge.0);
            let cut = cut || edge.0 == 0;
            (!cut || width > period_ns).then_some((edge.0, width))
        });
        pulse.collect()
    }
}

/// Length of a tick: numerator and denominator of nanoseconds.
fn tick(count: u32, unit: TimescaleUnit) -> (u64, u64) {
    let count = u64::from(count);
    match unit {
        TimescaleUnit::S => (count * 1_000_000_000, 1),
        TimescaleUnit::MS => (count * 1_000_000, 1),
        TimescaleUnit::US => (count * 1000, 1),
        TimescaleUnit::NS => (count, 1),
        TimescaleUnit::PS => (count, 1000),
        TimescaleUnit::FS => (count, 1_000_000),
    }
}

/// Most bytes of the declarations, and of a comment or a value.
const MOST_WORDS: u64 = 1 << 20;

/// A stream of which a parser that collects words takes a bounded part at a time.
struct Portioned<'a, R> {
    input: R,
    left: &'a Cell<u64>,
}

impl<R: Read> Read for Portioned<'_, R> {
    fn read(&mut self, out: &mut [u8]) -> io::Result<usize> {
        if self.left.get() == 0 {
            let what = format!("declarations, comments or values of more than {MOST_WORDS} bytes");
            return Err(io::Error::other(what));
        }
        let most = out
            .len()
            .min(usize::try_from(self.left.get()).unwrap_or(usize::MAX));
        let read = self.input.read(&mut out[..most])?;
        self.left.set(self.left.get() - read as u64);
        Ok(read)
    }
}

/// Declarations of a dump: scalar variables, and the length of a tick.
struct Declared {
    scalars: Vec<(IdCode, String)>,
    timescale: (u32, TimescaleUnit),
}

/// Reads the declarations one by one: scopes may lie in one another as deep as they like.
fn declared<R: BufRead>(parser: &mut Parser<R>) -> io::Result<Declared> {
    let mut found = Declared {
        scalars: Vec::new(),
        timescale: (1, TimescaleUnit::NS),
    };
    loop {
        match parser.next().transpose()? {
            Some(Command::Timescale(count, unit)) => found.timescale = (count, unit),
            Some(Command::VarDef(kind, 1, code, name, _)) if kind != VarType::Real => {
                found.scalars.push((code, name));
            }
            Some(Command::Enddefinitions) => return Ok(found),
            Some(
                Command::VarDef(..)
                | Command::ScopeDef(..)
                | Command::Upscope
                | Command::Comment(_)
                | Command::Date(_)
                | Command::Version(_),
            ) => {}
            Some(_) => return Err(io::Error::other("a value before $enddefinitions")),
            None => {
                let kind = io::ErrorKind::UnexpectedEof;
                return Err(io::Error::new(kind, "no $enddefinitions"));
            }
        }
    }
}

pub(super) fn read_vcd(label: &str, input: impl Read) -> Result<Capture, FileError> {
    let mut text = Text::new(label, input, LONGEST_LINE);
    let left = Cell::new(MOST_WORDS);
    let mut parser = Parser::new(BufReader::new(Portioned {
        input: &mut text,
        left: &left,
    }));
    let Declared {
        scalars: names,
        timescale: (count, unit),
    } = match declared(&mut parser) {
        Ok(declared) => declared,
        Err(error) => {
            let mut told = FileError::of_io(label, "a value change dump (VCD)", error);
            told.line = told.line.or(usize::try_from(parser.line()).ok());
            return Err(told);
        }
    };
    let (up, down) = tick(count, unit);
    let mut capture = Capture {
        resolution_ns: (up / down).max(1),
        ..Capture::default()
    };
    let mut places = BTreeMap::new();
    for (code, name) in names {
        places.entry(code).or_insert_with(|| {
            capture.signals.push(Signal {
                name,
                edges: Vec::new(),
            });
            capture.signals.len() - 1
        });
    }
    let (mut now, mut changes) = (0, 0);
    loop {
        left.set(MOST_WORDS);
        let Some(command) = parser.next() else { break };
        match command {
            Ok(Command::Timestamp(t)) => now = (t.saturating_mul(up) / down).max(now),
            Ok(Command::ChangeScalar(code, value)) => {
                if let Some(&place) = places.get(&code) {
                    // Unknown and floating are not driven.
                    changes += usize::from(capture.signals[place].set(now, value == Value::V1));
                    if changes > MOST_CHANGES {
                        let line = usize::try_from(parser.line()).unwrap_or(0);
                        return Err(too_long(label, line));
                    }
                }
            }
            Ok(_) => {}
            Err(error) => {
                let line = parser.line();
                let edges: usize = capture.signals.iter().map(|s| s.edges.len()).sum();
                capture.notes.push(format!(
                    "{label}:{line}: {error}; {edges} changes until {:.6} s were read",
                    now as f64 * 1e-9
                ));
                break;
            }
        }
    }
    drop(parser);
    capture.notes.extend(text.note());
    capture.end_ns = now;
    Ok(capture)
}
