//! Records that grow while fingers run: the loops' reports, in the numbers of the bench and in the order of time.

use std::path::PathBuf;

use palpate_core::bus::Received;
use palpate_core::units::Instant;
use palpate_files::{Format, Setup};
use palpate_records::readings::{ModulePlaces, TaxelFrame};
use palpate_records::trace::{Event, Header, sort_by_time};
use palpate_run::picture::State;
use palpate_run::place::Place;
use palpate_run::{Failure, TurnView, Wish, attachments, joined_header, whole_boards};

use crate::output::Outputs;
use crate::record::{About, Journal, Sink, path_of};
use crate::views::Views;

/// Report of a finger's loop.
#[derive(Debug, Default)]
pub(super) struct Said {
    pub(super) finger: usize,
    /// Time before everything that the loop tells next.
    pub(super) until: Instant,
    /// Events in the finger's own numbers.
    pub(super) events: Vec<Event>,
    pub(super) frames: Vec<Received>,
    pub(super) taxels: Vec<TaxelFrame>,
    /// Readings of the finger's taxels, for live views; with its buses in words, and its state.
    pub(super) counts: Vec<f32>,
    pub(super) buses: Vec<String>,
    pub(super) state: Option<State>,
}

/// One finger's part of the records.
struct Own {
    place: Place,
    /// Files of its own, where there are any.
    journal: Option<Journal>,
    /// Time before which no more will come from the finger.
    until: Instant,
    /// All events of the finger, for the live view.
    seen: Vec<Event>,
}

/// The files of a run.
pub(super) struct Records {
    fingers: Vec<Own>,
    /// Files of all fingers.
    common: Journal,
    /// Data that waits for fingers that are behind.
    events: Vec<Event>,
    frames: Vec<Received>,
    taxels: Vec<TaxelFrame>,
    views: Views,
}

impl Records {
    /// Creates the files. With `tells`, notes go to people as well.
    pub(super) fn create(
        setup: &Setup,
        fingers: &[(&Place, &Header, &[ModulePlaces])],
        (files, outputs): (&[(Format, PathBuf)], Outputs<'_>),
        tells: bool,
    ) -> Result<Self, Failure> {
        let attached = attachments(setup);
        // All files of the only display are the run's.
        let only = fingers.iter().find(|(place, ..)| place.name.is_none());
        let (own, shared): (Vec<_>, Vec<_>) = files
            .iter()
            .cloned()
            .partition(|(format, _)| only.is_none() && format.is_per_display());
        let joined = || {
            let headers: Vec<_> = fingers.iter().map(|(p, h, _)| (*p, *h)).collect();
            joined_header(setup, &headers)
        };
        let header = only.map_or_else(joined, |(_, header, _)| (*header).clone());
        let modules = only.map_or(&[][..], |(.., modules)| modules);
        let about = About::Run(&header, modules, &attached);
        let sinks = Sink::create_all(&shared, &about, outputs)?;
        let of = |(place, header, modules): &(&Place, &Header, &[_])| {
            let path =
                |(format, path): &(Format, PathBuf)| (*format, path_of(path, place.display()));
            let files: Vec<_> = own.iter().map(path).collect();
            let about = About::Run(header, modules, &attached);
            let sinks = Sink::create_all(&files, &about, outputs)?;
            let journal = (!sinks.is_empty()).then(|| Journal::start(sinks, false));
            Ok(Own {
                place: (*place).clone(),
                journal: journal.transpose()?,
                until: Instant::ZERO,
                seen: Vec::new(),
            })
        };
        Ok(Self {
            fingers: fingers.iter().map(of).collect::<Result<_, Failure>>()?,
            common: Journal::start(sinks, tells)?,
            events: Vec::new(),
            frames: Vec::new(),
            taxels: Vec::new(),
            views: Views::default(),
        })
    }

    /// Shows the fingers to a person as well.
    pub(super) fn show(&mut self, views: Views) {
        self.views = views;
    }

    /// Tells whether a view is open.
    pub(super) const fn are_seen(&self) -> bool {
        self.views.are_open()
    }

    /// Passes on [`Views::wish`].
    pub(super) fn wish(&self) -> Option<Wish> {
        self.views.wish()
    }

    /// Takes what a finger says; whether those who look on want the run to end.
    pub(super) fn take(&mut self, said: Said) -> bool {
        let Some(own) = self.fingers.get_mut(said.finger) else {
            return false;
        };
        if self.views.are_open() {
            own.seen.extend_from_slice(&said.events);
        }
        // The end is not shown: the screen keeps its last view.
        let state = said.state.filter(|_| said.until < Instant::FAR_FUTURE);
        let ends = state.is_some_and(|state| {
            self.views.turn(&TurnView {
                now: said.until,
                display: said.finger,
                events: &own.seen,
                counts: &said.counts,
                buses: &|| said.buses.clone(),
                state: &|_| state.clone(),
            })
        });
        let mut events = said.events;
        events.iter_mut().for_each(|event| own.place.number(event));
        self.events
            .extend(events.iter().filter_map(|event| own.place.joined(event)));
        match &mut own.journal {
            Some(journal) => journal.add(&events, said.frames.clone(), said.taxels),
            None => self.taxels.extend(said.taxels),
        }
        self.frames.extend(said.frames);
        own.until = said.until;
        let until = self.fingers.iter().map(|finger| finger.until).min();
        self.pass_on(until.unwrap_or(Instant::FAR_FUTURE));
        ends
    }

    /// Adds events of whole boards, or of the whole bench.
    pub(super) fn add(&mut self, events: Vec<Event>) {
        self.events.extend(events);
    }

    /// Starts and ends of boards, which all displays on a board have alike; in their own numbers.
    pub(super) fn boards(&self, fingers: &[Vec<Event>]) -> Vec<Event> {
        let numbered = self.fingers.iter().zip(fingers).map(|(own, events)| {
            let mut events = events.clone();
            events.iter_mut().for_each(|event| own.place.number(event));
            (&own.place, events)
        });
        let numbered: Vec<_> = numbered.collect();
        let each = numbered.iter().map(|(place, events)| (*place, &**events));
        whole_boards(&each.collect::<Vec<_>>())
    }

    /// Writes everything that is older than anything still to come.
    fn pass_on(&mut self, until: Instant) {
        let until_us = until.as_micros();
        sort_by_time(&mut self.events);
        self.frames.sort_by_key(|frame| frame.at);
        let old = |event: &Event| event.t_ns() / 1000 < until_us;
        let later = self.events.partition_point(old);
        let frames = self.frames.partition_point(|frame| frame.at < until);
        let taxels = self.taxels.partition_point(|scan| scan.t_us < until_us);
        let events: Vec<Event> = self.events.drain(..later).collect();
        let frames: Vec<Received> = self.frames.drain(..frames).collect();
        let taxels: Vec<TaxelFrame> = self.taxels.drain(..taxels).collect();
        if !(events.is_empty() && frames.is_empty() && taxels.is_empty()) {
            self.common.add(&events, frames, taxels);
        }
    }

    /// Tells whether a file could not be written: a full disk ends the run.
    pub(super) fn have_failed(&self) -> bool {
        let own = self.fingers.iter().filter_map(|f| f.journal.as_ref());
        self.common.has_failed() || own.into_iter().any(Journal::has_failed)
    }

    /// Ends the files. Returns the number of frames that found no room, and the first error.
    pub(super) fn finish(mut self) -> (u64, Result<(), Failure>) {
        drop(std::mem::take(&mut self.views));
        self.pass_on(Instant::FAR_FUTURE);
        let own = self.fingers.into_iter().filter_map(|f| f.journal);
        let journals: Vec<Journal> = own.chain([self.common]).collect();
        let dropped = journals.iter().map(Journal::dropped).sum();
        let ended = journals.into_iter().map(Journal::finish);
        (dropped, ended.fold(Ok(()), Result::and))
    }
}
