//! A recording of a run as pictures of any moment: its events once more, through the painter that a live view has.
//!
//! Nothing of the recording is held but a mark every so often: where a record begins, and what the painter knew there. A
//! picture of another moment is painted from the mark before it.

mod player;

pub use player::{Moment, Past, Player, SoFar};

use std::io::{self, Read};

use palpate_core::contact::Levels;
use palpate_core::illusion::Map;
use palpate_files::{FileError, Setup};
use palpate_records::mcap::{McapReader, Told, Unreadable};
use palpate_records::trace::{Event, Source, event};

use crate::failure::Failure;
use crate::header::header;
use crate::loops::build;
use crate::picture::{Head, Memory, Painter};
use crate::place::{Place, fingers};

/// Time before a moment for which temperatures are shown, microseconds.
const WARM_US: u64 = 30_000_000;
/// Bytes of a file that are read for the past of a moment.
const MOST_PAST: u64 = 16 << 20;
/// Time between two marks, microseconds, and most marks: beyond, every other one is dropped.
const MARK_US: u64 = 500_000;
const MARKS: usize = 4096;

/// A place to begin at.
#[derive(Clone, Debug)]
struct Mark {
    offset: u64,
    t_us: u64,
    memory: Memory,
}

/// A recording of a run that was read through once.
#[derive(Debug)]
pub struct Recorded {
    head: Head,
    label: String,
    /// Time of the last message, microseconds.
    end_us: u64,
    /// Damage of the file, a place each.
    damages: Vec<String>,
    /// Panels of a page for which the recording has no messages.
    lacks: Vec<&'static str>,
    /// Painter before the first event.
    painter: Painter,
    map: Map,
    /// Board and channel of each wire, and how many taxels each module has.
    outputs: Vec<(u8, u8)>,
    taxels: Vec<usize>,
    place: Option<Place>,
    topics: McapReader<io::Empty>,
    marks: Vec<Mark>,
}

/// Kinds of messages in the recording.
#[derive(Default)]
struct Seen {
    taxels: bool,
    contacts: bool,
    pins: bool,
    warm: bool,
    felt: bool,
}

impl Seen {
    const fn look(&mut self, told: &Told) {
        match told {
            Told::Taxels { .. } => self.taxels = true,
            Told::Pin { .. } => self.pins = true,
            Told::Event(Event::Contact(_)) => self.contacts = true,
            Told::Event(Event::Wire(_) | Event::Skin(_)) => self.warm = true,
            Told::Event(Event::Felt(_)) => self.felt = true,
            Told::Event(_) => {}
        }
    }

    fn lacks(&self) -> Vec<&'static str> {
        let all = [
            (self.taxels, "readings of taxels"),
            (self.contacts, "contacts"),
            (self.pins, "pins"),
            (self.warm, "temperatures"),
            (self.felt, "felt places"),
        ];
        let lacking = all.iter().filter(|(seen, _)| !seen);
        lacking.map(|(_, what)| *what).collect()
    }
}

impl Recorded {
    /// Reads a recording through; `label` names it in errors.
    ///
    /// # Errors
    /// [`Failure::File`] for what is no recording of a run, or of several displays at once.
    pub fn read(label: &str, input: impl Read) -> Result<Self, Failure> {
        let unreadable = |e: Unreadable| FileError::whole(label, e.expected, e.found);
        let mut reader = McapReader::of_run(input).map_err(unreadable)?;
        let start = reader.between();
        // The files of the run stand before its messages.
        let mut next = reader.told().map_err(unreadable)?;
        let mut recorded = match reader.so_far().metadata.contains_key("scene") {
            true => Self::begin(label, &reader)?,
            false => {
                let read = reader.into_read().map_err(unreadable)?;
                let found = format!(
                    "one of buses alone ({}); `hil run SCENE --replay {label} --serve` plays it",
                    read.metadata.get("interfaces").map_or("unknown", |i| i)
                );
                return Err(FileError::whole(label, "a recording of a run", found).into());
            }
        };
        let mut painter = recorded.painter.clone();
        recorded.marks.extend(start.map(|offset| Mark {
            offset,
            t_us: 0,
            memory: painter.memory().clone(),
        }));
        let (mut seen, mut every_us) = (Seen::default(), MARK_US);
        while let Some(told) = next {
            let t_us = told.t_ns() / 1000;
            recorded.end_us = recorded.end_us.max(t_us);
            seen.look(&told);
            painter.pass(recorded.event(told).as_slice());
            let due = recorded
                .marks
                .last()
                .is_none_or(|m| t_us >= m.t_us + every_us);
            if let Some(offset) = reader.between().filter(|_| due) {
                recorded.marks.push(Mark {
                    offset,
                    t_us,
                    memory: painter.memory().clone(),
                });
                if recorded.marks.len() > MARKS {
                    every_us *= 2;
                    let mut odd = false;
                    recorded.marks.retain(|_| {
                        odd = !odd;
                        odd
                    });
                }
            }
            next = reader.told().map_err(unreadable)?;
        }
        let damages = &reader.so_far().damages;
        recorded.damages = damages.iter().map(ToString::to_string).collect();
        recorded.lacks = seen.lacks();
        recorded.topics = reader.resumed(io::empty(), 0);
        Ok(recorded)
    }

    /// Begins with the files that the recording has with it.
    fn begin<R: Read>(label: &str, reader: &McapReader<R>) -> Result<Self, Failure> {
        let said = reader.so_far();
        let fact = |key: &str| said.metadata.get(key).map_or("", String::as_str);
        let attached = |name: &str| {
            let file = said.attachments.iter().find(|(file, _)| file == name)?;
            String::from_utf8(file.1.clone()).ok()
        };
        let mut setup = Setup::attached(label, attached)?;
        if setup.scene.value.name != fact("scene") {
            // A recording was played, not the scene's own touches.
            setup.scene.value.touches.clear();
            setup.scene.value.name = fact("scene").to_owned();
        }
        let source = Source::named(fact("source")).unwrap_or(Source::Real);
        let mut place = None;
        if !setup.fingers.is_empty() {
            let of_bench = |(_, alone): &(Place, Setup)| alone.bench.value.name == fact("bench");
            let own = fingers(&setup).into_iter().find(of_bench);
            let (own, alone) = own.ok_or_else(|| {
                let found = format!("one of all displays of `{}`", fact("bench"));
                FileError::whole(label, "a recording of one display", found)
            })?;
            (place, setup) = (Some(own), alone);
        }
        if source == Source::Observed {
            setup = setup.observed()?;
        }
        let seed = fact("seed").parse().unwrap_or(1);
        let projector = build(&setup, seed, Levels::Off)?;
        let mut header = header(&setup, seed, &projector)?;
        header.source = source;
        if let Some(place) = &place {
            place.number_header(&mut header);
        }
        let modules = projector.layout().modules();
        Ok(Self {
            head: Head::new(&setup, &header, &projector),
            label: label.to_owned(),
            end_us: 0,
            damages: Vec::new(),
            lacks: Vec::new(),
            painter: Painter::new(&setup, &header, &projector),
            map: *projector.map(),
            outputs: header.wires.iter().map(|w| (w.board, w.channel)).collect(),
            taxels: modules.iter().map(|m| m.points().len()).collect(),
            place,
            topics: reader.resumed(io::empty(), 0),
            marks: Vec::new(),
        })
    }

    /// Head of the recorded session.
    #[must_use]
    pub const fn head(&self) -> &Head {
        &self.head
    }

    /// Time of the last message, microseconds.
    #[must_use]
    pub const fn end_us(&self) -> u64 {
        self.end_us
    }

    /// Damage of the file, a place each; empty for a whole one.
    #[must_use]
    pub fn damages(&self) -> &[String] {
        &self.damages
    }

    /// Panels of a page for which the recording has no messages.
    #[must_use]
    pub fn lacks(&self) -> &[&'static str] {
        &self.lacks
    }

    /// A message as an event, by the display's own numbers of its modules.
    fn event(&self, told: Told) -> Option<Event> {
        match told {
            Told::Event(Event::Contact(mut now)) => {
                let own = self.place.as_ref().and_then(|of| {
                    let mut modules = of.modules.iter();
                    modules.position(|m| *m == usize::from(now.module))
                });
                let own = own.and_then(|m| u16::try_from(m).ok());
                now.module = own.unwrap_or(now.module);
                Some(Event::Contact(now))
            }
            Told::Event(event) => Some(event),
            Told::Pin { t_ns, wire, high } => {
                let &(board, channel) = self.outputs.get(usize::from(wire))?;
                Some(Event::Edge(event::Edge {
                    t_ns,
                    board,
                    channel,
                    high,
                }))
            }
            Told::Taxels { .. } => None,
        }
    }

    /// The mark from which the past of a moment is painted.
    fn mark(&self, at_us: u64) -> Option<&Mark> {
        let before = |t_us: u64| {
            self.marks
                .partition_point(|m| m.t_us <= t_us)
                .checked_sub(1)
        };
        let last = self.marks.get(before(at_us)?)?;
        let first = before(at_us.saturating_sub(WARM_US)).unwrap_or(0);
        let near = |m: &&Mark| m.offset + MOST_PAST >= last.offset;
        self.marks[first..].iter().find(near)
    }
}

#[cfg(test)]
#[path = "recorded_tests.rs"]
mod tests;
