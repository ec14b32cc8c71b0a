//! What a comparison sees of a run, whichever file it comes from.

use std::collections::BTreeMap;
use std::fmt;

use crate::bursts::bursts;
use crate::golden::schedule_golden;
use crate::trace::{Source, Trace};

use super::golden::{moment, read_golden};
use super::schedule::read_schedule;
use crate::trace::WireInfo;
use crate::words::{Happening, happenings, line};

/// Which of our texts it is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Kind {
    /// What was left of every limit.
    Margins,
    /// What the wires were told.
    Schedule,
    /// What the compression found.
    Contacts,
    /// A scene over force and speed.
    Surface,
}

impl Kind {
    /// Every kind, in the order a review shows them.
    pub const ALL: [Self; 4] = [Self::Margins, Self::Schedule, Self::Contacts, Self::Surface];

    /// The words of its first line.
    pub const fn title(self) -> &'static str {
        match self {
            Self::Margins => "margins",
            Self::Schedule => "schedule",
            Self::Contacts => "contact path",
            Self::Surface => "surface",
        }
    }
}

/// What is driven: a wire of the display, or an output that drives none.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Output {
    /// By its index in the display's layout.
    Wire(u16),
    /// By board and channel.
    Pin(u8, u8),
}

impl fmt::Display for Output {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Wire(wire) => write!(out, "wire {wire}"),
            Self::Pin(board, channel) => write!(out, "output {board}:{channel}"),
        }
    }
}

/// One burst of one output.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Stay {
    /// Rising edge, microseconds.
    pub from_us: u64,
    /// Falling edge, microseconds.
    pub to_us: u64,
    /// Width applied, ticks; 0 is a refusal.
    pub width: u16,
    /// Width asked for, ticks.
    pub requested: u16,
    /// Why they differ: a word of the guard's.
    pub reason: Option<String>,
}

/// One piece of a header: `tau_d 35.000 ms` under `tau_d`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Item {
    /// What names it.
    pub key: String,
    /// The whole of it.
    pub text: String,
}

/// A measured value beside its limit.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Figure {
    /// What was measured.
    pub name: String,
    /// How much, as printed; `-` where nothing measured it.
    pub value: String,
    /// Its unit; empty for a count.
    pub unit: String,
    /// The limit, as printed; `-` where there is none.
    pub limit: String,
    /// Part of the limit that was used, as printed, in percent; `-` where there is none.
    pub used: String,
}

/// Something that happened at a time.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Moment {
    /// When, as printed.
    pub when: String,
    /// Its kind's word.
    pub kind: String,
    /// What.
    pub text: String,
}

/// A run as a comparison sees it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Story {
    /// Which text it was read from.
    pub kind: Kind,
    /// The scene's name.
    pub scene: String,
    /// Whether hardware took part.
    pub source: Source,
    /// What the header says.
    pub head: Vec<Item>,
    /// The strip chart, line by line, with its heading.
    pub chart: Vec<String>,
    /// What happened.
    pub moments: Vec<Moment>,
    /// Where the text counts more of them than it lists: the last one listed, milliseconds.
    pub moments_until_ms: Option<i64>,
    /// What it came to.
    pub figures: Vec<Figure>,
    /// Rows of its tables, each under what names it.
    pub rows: Vec<Item>,
    /// Bursts of each output, sorted.
    pub bursts: BTreeMap<Output, Vec<Stay>>,
    /// Bursts that the text counts and does not list.
    pub untold: u64,
    /// Digests by what they are of.
    pub digests: Vec<Item>,
    /// From a schedule file, which says less: what it lacks is no difference.
    pub partial: bool,
}

/// What is wrong with a text, and where.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Damage {
    /// Line, counted from one.
    pub line: usize,
    /// What should be there.
    pub expected: String,
    /// What is.
    pub found: String,
}

impl fmt::Display for Damage {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self {
            line,
            expected,
            found,
        } = self;
        write!(out, "line {line}: expected {expected}, found {found}")
    }
}

/// As a golden prints it, and reads it.
fn moment_of(happening: &Happening) -> Option<Moment> {
    moment(&line(happening))
}

impl Story {
    /// Of a run in memory.
    ///
    /// # Errors
    /// Where the run's own golden cannot be read back.
    pub fn of_trace(trace: &Trace) -> Result<Self, Damage> {
        let mut story = read_golden(&schedule_golden(trace))?;
        story.untold = 0;
        story.bursts = BTreeMap::new();
        story.moments_until_ms = None;
        story.moments = happenings(trace).iter().filter_map(moment_of).collect();
        for burst in bursts(trace) {
            let output = match burst.wire {
                Some(wire) => Output::Wire(wire),
                None => Output::Pin(burst.output.0, burst.output.1),
            };
            story.bursts.entry(output).or_default().push(Stay {
                from_us: burst.from_us,
                to_us: burst.to_us,
                width: burst.width,
                requested: burst.requested,
                reason: burst.reason.map(|r| r.word().to_owned()),
            });
        }
        Ok(story)
    }

    /// Of a golden, with insta's heading or without.
    ///
    /// # Errors
    /// The first line that no golden has there.
    pub fn of_golden(text: &str) -> Result<Self, Damage> {
        read_golden(text)
    }

    /// Of a schedule file (JSON Lines); `wires` finds the wires of a bench by its name.
    ///
    /// # Errors
    /// The first line that no schedule has there.
    pub fn of_schedule(
        text: &str,
        wires: impl FnOnce(&str) -> Vec<WireInfo>,
    ) -> Result<Self, Damage> {
        let mut story = Self::of_trace(&read_schedule(text, wires)?)?;
        const HEAD: [&str; 7] = ["bench", "seed", "scene", "limits", "PWM", "tau_d", "SOA"];
        const FIGURES: [&str; 4] = ["stimuli", "widest pulse", "largest duty", "longest burst"];
        story.head.retain(|i| HEAD.contains(&i.key.as_str()));
        story.figures.retain(|f| FIGURES.contains(&f.name.as_str()));
        story.rows.clear();
        story.digests.retain(|d| d.key == "schedule");
        story.partial = true;
        Ok(story)
    }
}
