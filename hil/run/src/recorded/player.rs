//! Player of a recording: to the next moment, or to any other one.

use std::io::Read;
use std::sync::Arc;

use palpate_core::units::Instant;
use palpate_files::FileError;
use palpate_records::mcap::{McapReader, Told};
use palpate_records::trace::Event;
use serde::Serialize;

use super::{Recorded, WARM_US};
use crate::failure::Failure;
use crate::picture::{Painter, Picture, State};

/// Time before a moment that a page's plots show, microseconds: bursts, single pulses and felt places.
const BURSTS_US: u64 = 4_000_000;
const EDGES_US: u64 = 300_000;
const FELT_US: u64 = 400_000;
/// Time between two temperatures of the past.
const WARM_EVERY_US: u64 = 100_000;
/// Longest way to a later moment that is played on; for a longer one the player begins anew, since no eye would see
/// what lies between.
const STEP_US: u64 = 2_000_000;
/// Notes of the past that are shown, the newest.
const NOTES: usize = 60;

/// Data of a page's plots for the time before a moment.
#[derive(Clone, Debug, Default, Serialize)]
pub struct Past {
    /// Time from which the past is known, microseconds.
    pub from_us: u64,
    /// The skin under each wire, degrees C, ten times per second.
    pub warm: Vec<(u64, Vec<f64>)>,
}

/// A moment of a recording, for a page.
#[derive(Clone, Debug, Serialize)]
pub struct Moment {
    /// Events since the last moment, and the state now.
    pub picture: Picture,
    /// Past of the plots, where the page begins anew; null where it goes on.
    pub past: Option<Past>,
    /// Totals of the run so far, as far as its events tell them.
    pub totals: SoFar,
}

/// Totals of a recorded run so far.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct SoFar {
    /// Stimuli with a pulse.
    pub stimuli: u64,
    /// Stimuli of which the guard applied something other than was requested.
    pub limited: u32,
    /// The hottest that the skin was at a stimulus, degrees C; none where nothing measured it.
    pub hottest_c: Option<f64>,
}

/// Shows a recording: one moment after another, or any other one.
#[derive(Debug)]
pub struct Player<R, F> {
    pub(super) recorded: Arc<Recorded>,
    /// Opens the recording at a byte.
    open: F,
    reader: Option<McapReader<R>>,
    painter: Painter,
    /// The newest reading of every taxel; empty before the first.
    counts: Vec<f32>,
    /// Message that was read and is later than the shown moment.
    ahead: Option<Told>,
    now_us: u64,
}

impl<R: Read, F: Fn(u64) -> R> Player<R, F> {
    /// A player of a recording that `open` gives from any byte on.
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
        let state = State::recorded(Instant::from_micros(at_us), self.recorded.map);
        // A seek shows events that the painter has passed already.
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

    /// Checks that the file is still the one that was read through: it has no damage that it did not have then.
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

    /// Goes to the mark before a moment's past and on to the moment. Events on the way that a page shows go to `shown`.
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
                Event::Edge(_) => is_new(EDGES_US),
                Event::Felt(_) => is_new(FELT_US),
                Event::Note(_) => true,
                _ => false,
            };
            if keeps {
                shown.push(event);
            }
        })?;
        // Of events that are kept at any age, the newest are shown.
        let is_old = |event: &Event| match event {
            Event::Schedule(entry) => entry.until.as_micros() + BURSTS_US < at_us,
            Event::Note(_) => true,
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

    /// Reads on to a moment; events go to `each`.
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
