//! A recording of a run as pictures of any moment: its events once more, through the painter that a live view has.
//!
//! Nothing of the recording is held but a mark every so often: where a record begins, and what the painter knew there. A
//! picture of another moment is painted from the mark before it.

use std::io::{self, Read};
use std::sync::Arc;

use palpate_core::contact::Levels;
use palpate_core::illusion::Map;
use palpate_core::units::Instant;
use palpate_files::{FileError, Setup};
use palpate_records::mcap::{McapReader, Told, Unreadable};
use palpate_records::trace::{Event, Source};
use serde::Serialize;

use super::painter::Memory;
use super::{Head, Painter, Picture, State};
use crate::failure::Failure;
use crate::header::header;
use crate::place::{Place, fingers};
use crate::runner::build;

/// What a page's plots reach back, microseconds: temperatures, bursts, single pulses and felt places.
const WARM_US: u64 = 30_000_000;
const BURSTS_US: u64 = 4_000_000;
const EDGES_US: u64 = 300_000;
const FELT_US: u64 = 400_000;
/// Between two temperatures of the past.
const WARM_EVERY_US: u64 = 100_000;
/// A later moment is gone on to when it is no further away, else begun anew: what lies between would be seen by no eye.
const STEP_US: u64 = 2_000_000;
/// How much of a file is read for the past of a moment, bytes.
const MOST_PAST: u64 = 16 << 20;
/// Time between two marks, microseconds, and how many there are at most: beyond, every other one goes.
const MARK_US: u64 = 500_000;
const MARKS: usize = 4096;
/// Notes of the past that are told, the newest.
const NOTES: usize = 60;

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
    /// When the last message was, microseconds.
    end_us: u64,
    /// What is wrong with the file.
    damages: Vec<String>,
    /// What there is nothing of in it.
    lacks: Vec<&'static str>,
    /// That has seen nothing.
    painter: Painter,
    map: Map,
    /// Board and channel of each wire, and how many taxels each module has.
    outputs: Vec<(u8, u8)>,
    taxels: Vec<usize>,
    place: Option<Place>,
    topics: McapReader<io::Empty>,
    marks: Vec<Mark>,
}

/// What kinds of messages there were.
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
            Told::Event(Event::Contact { .. }) => self.contacts = true,
            Told::Event(Event::Wire { .. } | Event::Skin { .. }) => self.warm = true,
            Told::Event(Event::Felt { .. }) => self.felt = true,
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

    /// From the files that the recording has with it.
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
        let source = Source::of(fact("source")).unwrap_or(Source::Real);
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

    /// What stays as it is.
    #[must_use]
    pub const fn head(&self) -> &Head {
        &self.head
    }

    /// When it ends, microseconds.
    #[must_use]
    pub const fn end_us(&self) -> u64 {
        self.end_us
    }

    /// What is wrong with the file, a place each; empty for a whole one.
    #[must_use]
    pub fn damages(&self) -> &[String] {
        &self.damages
    }

    /// What a page has panels for and the recording nothing of.
    #[must_use]
    pub fn lacks(&self) -> &[&'static str] {
        &self.lacks
    }

    /// A message as an event, by the display's own numbers of its modules.
    fn event(&self, told: Told) -> Option<Event> {
        match told {
            Told::Event(Event::Contact {
                t_us,
                frame,
                module,
                contact,
                place,
                intensity_milli,
                level,
                members,
            }) => {
                let own =
                    |modules: &[usize]| modules.iter().position(|m| *m == usize::from(module));
                let own = self.place.as_ref().and_then(|of| own(&of.modules));
                Some(Event::Contact {
                    t_us,
                    frame,
                    module: own.and_then(|m| u16::try_from(m).ok()).unwrap_or(module),
                    contact,
                    place,
                    intensity_milli,
                    level,
                    members,
                })
            }
            Told::Event(event) => Some(event),
            Told::Pin { t_ns, wire, high } => {
                let &(board, channel) = self.outputs.get(usize::from(wire))?;
                Some(Event::Edge {
                    t_ns,
                    board,
                    channel,
                    high,
                })
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

/// What a page's plots show of the time before a moment.
#[derive(Clone, Debug, Default, Serialize)]
pub struct Past {
    /// From when on it is known, microseconds.
    pub from_us: u64,
    /// The skin under each wire, degrees C, ten times per second.
    pub warm: Vec<(u64, Vec<f64>)>,
}

/// What a page is shown of a moment.
#[derive(Clone, Debug, Serialize)]
pub struct Moment {
    /// What happened since the last one, and how things are.
    pub picture: Picture,
    /// Where nothing that was shown before goes on: what the plots begin with.
    pub past: Option<Past>,
    /// What the run came to so far, as far as its events say it.
    pub totals: SoFar,
}

/// What a recorded run came to so far.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct SoFar {
    /// Stimuli with a pulse.
    pub stimuli: u64,
    /// Of how many the guard applied something other than what was requested.
    pub limited: u32,
    /// The hottest that the skin was at a stimulus, degrees C; none where nothing measured it.
    pub hottest_c: Option<f64>,
}

/// Shows a recording: one moment after another, or any other one.
#[derive(Debug)]
pub struct Player<R, F> {
    recorded: Arc<Recorded>,
    /// Opens the recording at a byte.
    open: F,
    reader: Option<McapReader<R>>,
    painter: Painter,
    /// The newest reading of every taxel; empty before the first.
    counts: Vec<f32>,
    /// Read, and later than the moment that is shown.
    ahead: Option<Told>,
    now_us: u64,
}

impl<R: Read, F: Fn(u64) -> R> Player<R, F> {
    /// Of a recording that `open` gives from any byte on.
    pub fn new(recorded: Arc<Recorded>, open: F) -> Self {
        Self {
            painter: recorded.painter.clone(),
            recorded,
            open,
            reader: None,
            counts: Vec::new(),
            ahead: None,
            now_us: 0,
        }
    }

    /// The moment `at_us`, or the end where that is before it.
    ///
    /// # Errors
    /// [`Failure::File`] where the recording cannot be read any more.
    pub fn show(&mut self, at_us: u64) -> Result<Moment, Failure> {
        let at_us = at_us.min(self.recorded.end_us);
        let goes_on = (self.now_us..=self.now_us.saturating_add(STEP_US)).contains(&at_us);
        let mut past = None;
        let mut events = Vec::new();
        if self.reader.is_some() && goes_on {
            self.until(at_us, &mut |_, event| events.push(event))?;
        } else {
            past = Some(self.seek(at_us, &mut events)?);
        }
        if let Err(error) = self.is_the_same() {
            // The next moment is looked for anew.
            self.reader = None;
            return Err(error.into());
        }
        self.now_us = at_us;
        let state = State {
            now: Instant::from_micros(at_us),
            map: self.recorded.map,
            used: None,
            stopped: None,
            warm: Vec::new(),
            band_db: None,
            totals: None,
        };
        // What a seek shows was passed already.
        let passed = past.is_some().then(|| self.painter.memory().clone());
        let picture = self.painter.picture(&events, &self.counts, state);
        passed.iter().for_each(|memory| self.painter.recall(memory));
        let memory = self.painter.memory();
        let totals = SoFar {
            stimuli: memory.driven.stimuli,
            limited: memory.driven.limiter_events,
            hottest_c: memory.hottest_mc.map(|mc| f64::from(mc) * 1e-3),
        };
        Ok(Moment {
            picture,
            past,
            totals,
        })
    }

    /// Whether the file is still the one that was read through: nothing is wrong with it that was not wrong then.
    fn is_the_same(&self) -> Result<(), FileError> {
        let damages = self
            .reader
            .iter()
            .flat_map(|reader| &reader.so_far().damages);
        let known = &self.recorded.damages;
        let fresh = damages
            .map(ToString::to_string)
            .find(|d| !known.contains(d));
        fresh.map_or(Ok(()), |damage| {
            let expected = "the recording as it was when hil began to serve it (serve it again)";
            Err(FileError::whole(
                &self.recorded.label,
                expected,
                format!("another one, {damage}"),
            ))
        })
    }

    /// Goes to the mark before a moment's past and on to the moment. What is to be shown of the way goes to `shown`.
    fn seek(&mut self, at_us: u64, shown: &mut Vec<Event>) -> Result<Past, Failure> {
        let recorded = Arc::clone(&self.recorded);
        let Some(mark) = recorded.mark(at_us).or_else(|| recorded.marks.first()) else {
            return Ok(Past::default());
        };
        let begins = recorded
            .marks
            .first()
            .is_some_and(|first| first.offset == mark.offset);
        self.reader = Some(
            recorded
                .topics
                .resumed((self.open)(mark.offset), mark.offset),
        );
        self.painter.recall(&mark.memory);
        (self.ahead, self.counts) = (None, Vec::new());
        let from_us = match begins {
            true => 0,
            false => mark.t_us.max(at_us.saturating_sub(WARM_US)),
        };
        let mut past = Past {
            from_us,
            warm: Vec::new(),
        };
        let mut due_us = from_us;
        let mut notes = 0;
        self.until(at_us, &mut |painter, event| {
            let t_us = event.t_ns() / 1000;
            painter.pass(std::slice::from_ref(&event));
            if t_us >= due_us {
                let skin = painter.memory().warm.iter().map(|w| w[1]);
                past.warm.push((t_us, skin.collect()));
                due_us = t_us + WARM_EVERY_US;
            }
            let is_new = |span_us: u64| t_us + span_us >= at_us;
            let keeps = match &event {
                Event::Schedule(entry) => {
                    entry.until.as_micros() + BURSTS_US >= at_us || entry.reason.is_some()
                }
                Event::Edge { .. } => is_new(EDGES_US),
                Event::Felt { .. } => is_new(FELT_US),
                Event::Note { .. } => true,
                _ => false,
            };
            if keeps {
                shown.push(event);
            }
        })?;
        // Of what is kept however old it is the newest are told.
        let is_old = |event: &Event| match event {
            Event::Schedule(entry) => entry.until.as_micros() + BURSTS_US < at_us,
            Event::Note { .. } => true,
            _ => false,
        };
        let old = shown.iter().filter(|e| is_old(e)).count();
        shown.retain(|event| {
            let old_one = is_old(event);
            notes += usize::from(old_one);
            !old_one || notes + NOTES > old
        });
        Ok(past)
    }

    /// Reads on to a moment; what happened goes to `each`.
    fn until(
        &mut self,
        at_us: u64,
        each: &mut dyn FnMut(&mut Painter, Event),
    ) -> Result<(), Failure> {
        let recorded = Arc::clone(&self.recorded);
        let Some(reader) = &mut self.reader else {
            return Ok(());
        };
        loop {
            let next = match self.ahead.take() {
                Some(told) => Some(told),
                None => reader
                    .told()
                    .map_err(|e| FileError::whole(&recorded.label, e.expected, e.found))?,
            };
            let Some(told) = next else {
                return Ok(());
            };
            if told.t_ns() / 1000 > at_us {
                self.ahead = Some(told);
                return Ok(());
            }
            if let Told::Taxels {
                module, relative, ..
            } = told
            {
                read_taxels(
                    &mut self.counts,
                    &recorded.taxels,
                    usize::from(module),
                    &relative,
                );
            } else if let Some(event) = recorded.event(told) {
                each(&mut self.painter, event);
            }
        }
    }
}

/// Puts a module's readings in their place among those of all modules.
fn read_taxels(counts: &mut Vec<f32>, taxels: &[usize], module: usize, relative: &[u16]) {
    counts.resize(taxels.iter().sum(), 0.0);
    let first = taxels.iter().take(module).sum::<usize>();
    let own = counts.get_mut(first..).unwrap_or_default();
    let own = own
        .iter_mut()
        .take(taxels.get(module).copied().unwrap_or(0));
    own.zip(relative)
        .for_each(|(count, read)| *count = f32::from(*read));
}

#[cfg(test)]
#[path = "recorded_tests.rs"]
mod tests;
