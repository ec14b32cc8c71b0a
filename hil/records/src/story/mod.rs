//! A run as a golden tells it: one structure, made from a trace or read from a text; the text is rendered from it
//! and `diff` compares it.
//!
//! Two texts of a scene, so that a change shows where it belongs: the contact path and the schedule; and one of a
//! surface over many runs. ASCII, under 100 columns and 200 lines, built from integers. The chart's quantum follows
//! from the run's length alone; nothing random and no name of a file enters.

mod of_trace;
mod pad;
mod read;
mod strip;
mod table;
mod text;

pub use table::{Column, Role, Table};

use crate::bursts::Burst;
use crate::damage::Damage;
use crate::figures::Figure;
use crate::schedule::{header_pieces, read_schedule};
use crate::trace::{Source, Trace, WireInfo};
use crate::words::{Happening, HappeningKind};
use std::collections::BTreeMap;

/// Most characters on a line.
pub const COLUMNS: usize = 99;
/// Most lines of a golden.
pub const LINES: usize = 199;

/// Begins of the pieces that the header of every golden has, and the header of a schedule file.
const NAMED: [&str; 4] = ["bench ", "seed ", "scene ", "limits "];
/// Begins of the further pieces that the header of a schedule has: periods and times.
const DRIVEN: [&str; 6] = ["PWM ", "PRE_SCALE ", "period ", "tick ", "tau_d ", "SOA "];

palpate_core::listed! {
    /// Kind of a golden.
    #[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
    pub enum GoldenKind: title {
        /// Commands to the wires, and their results.
        Schedule = "schedule",
        /// Contacts that the compression found.
        Contacts = "contact path",
        /// A scene over force and speed.
        Surface = "surface",
    }
}

impl GoldenKind {
    /// The parts of a trace that goldens of the kind have digests of.
    const fn digests(self) -> &'static [&'static str] {
        match self {
            Self::Schedule => &["schedule", "trace"],
            Self::Contacts => &["contacts"],
            Self::Surface => &[],
        }
    }
}

/// The begin of a line with a digest. Its number is that of the bytes that are digested.
const DIGEST: &str = "digest 2 of";

/// A line of the header: pieces such as `tau_d 35.000 ms`, under a label or none.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct HeadLine {
    /// Subject of the pieces, such as `path error`.
    pub label: String,
    /// At least one; none holds a comma or colon.
    pub pieces: Vec<String>,
}

/// The times that bursts are compared by.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct StoryTiming {
    /// Length of a whole burst, microseconds.
    pub tau_d_us: u64,
    /// Time from onset to onset, microseconds.
    pub soa_us: u64,
    /// A tick of the pulse width, nanoseconds.
    pub tick_ns: u64,
}

/// A run as a golden tells it. From a text it holds what the text lists; from a trace, everything.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Story {
    /// Kind of the golden.
    pub kind: GoldenKind,
    /// The scene's name.
    pub scene: String,
    /// Emulated or real.
    pub source: Source,
    /// Lines of the header.
    pub head: Vec<HeadLine>,
    /// Times in the header of a schedule.
    pub timing: StoryTiming,
    /// Map of the pad of a contact path, line by line, with its heading.
    pub pad: Vec<String>,
    /// The strip chart, line by line, with its heading.
    pub chart: Vec<String>,
    /// Happenings, to the millisecond.
    pub happenings: Vec<Happening>,
    /// Happenings that the text counts and does not list.
    pub happenings_untold: u64,
    /// Totals and margins.
    pub figures: Vec<Figure>,
    /// Table of wires, contacts or points.
    pub table: Table,
    /// Every burst, sorted by start and output.
    pub bursts: Vec<Burst>,
    /// Bursts that the text counts and does not list.
    pub bursts_untold: u64,
    /// Digests by what they are of.
    pub digests: BTreeMap<&'static str, String>,
    /// `true` for a schedule file or a golden of an earlier version, which say less: what they lack is no difference.
    pub partial: bool,
}

impl Story {
    /// A story of nothing but its title.
    fn empty(kind: GoldenKind, scene: String, source: Source) -> Self {
        Self {
            kind,
            scene,
            source,
            head: Vec::new(),
            timing: StoryTiming::default(),
            pad: Vec::new(),
            chart: Vec::new(),
            happenings: Vec::new(),
            happenings_untold: 0,
            figures: Vec::new(),
            table: Table::new(kind),
            bursts: Vec::new(),
            bursts_untold: 0,
            digests: BTreeMap::new(),
            partial: false,
        }
    }

    /// Number of events, listed or not.
    pub(crate) const fn happening_count(&self) -> u64 {
        self.happenings.len() as u64 + self.happenings_untold
    }

    /// Number of bursts, listed or not.
    pub(crate) const fn burst_count(&self) -> u64 {
        self.bursts.len() as u64 + self.bursts_untold
    }

    /// The start of the last burst that it lists, microseconds, where it does not list all.
    pub fn listed_until_us(&self) -> Option<u64> {
        let last = self.bursts.last().map_or(0, |b| b.from_us);
        (self.bursts_untold > 0).then_some(last)
    }

    /// The start of the last happening that it lists, microseconds, where it does not list all.
    pub fn told_until_us(&self) -> Option<u64> {
        let last = self.happenings.last().map_or(0, |h| h.t_us);
        (self.happenings_untold > 0).then_some(last)
    }

    /// Reads a golden's text, with insta's heading or without.
    ///
    /// # Errors
    /// The first line that no golden has there.
    pub fn read(text: &str) -> Result<Self, Damage> {
        read::read(text)
    }

    /// Reads a schedule file (JSON Lines); `wires` finds the wires of a bench by its name.
    ///
    /// # Errors
    /// The first line that no schedule has there.
    pub fn of_schedule_file(
        text: &str,
        wires: impl FnOnce(&str) -> Vec<WireInfo>,
    ) -> Result<Self, Damage> {
        const FIGURES: [&str; 2] = ["stimuli", "largest duty"];
        let mut story = Self::schedule(&read_schedule(text, wires)?);
        for line in &mut story.head {
            let known = |p: &String| NAMED.iter().chain(&DRIVEN).any(|k| p.starts_with(k));
            line.pieces.retain(|p| line.label.is_empty() && known(p));
        }
        story.head.retain(|line| !line.pieces.is_empty());
        story.head.push(HeadLine {
            label: String::new(),
            pieces: header_pieces(text)?,
        });
        story.figures.retain(|f| FIGURES.contains(&f.name.as_str()));
        // Only these stand in the file as they happened; breaks and notes do not.
        let told = [HappeningKind::AllOff, HappeningKind::PreScale];
        story.happenings.retain(|h| told.contains(&h.kind));
        // Of contacts and breaks it knows nothing, so neither does its chart.
        story.chart.clear();
        story.table.rows.clear();
        story.digests.remove("trace");
        story.partial = true;
        Ok(story)
    }
}

/// The golden of a schedule: commands to the wires, and their results.
pub fn schedule_golden(trace: &Trace) -> String {
    Story::schedule(trace).text()
}

#[cfg(test)]
mod tests;
