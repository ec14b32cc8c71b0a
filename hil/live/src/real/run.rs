//! A run in real time, of one finger or of several: a loop each, records that grow, and a joint outcome. The only
//! display of a bench is a finger, too. Fingers share adapters, the clock, the guardian, and nothing else.

use std::collections::BTreeMap;

use palpate_buses::pacer::{Lateness, RunClock};
use palpate_buses::signals::Signals;
use palpate_core::contact::Levels;
use palpate_core::projector::Projector;
use palpate_core::units::{Duration, Instant};
use palpate_files::{BenchKind, Format, Real, Setup};
use palpate_records::readings::Readings;
use palpate_records::trace::{Event, Header, Ledger, event};
use palpate_run::effort::Effort;
use palpate_run::join::{Common, Part, join};
use palpate_run::pass::{self, PassEnd};
use palpate_run::place::Place;
use palpate_run::plan::Responses;
use palpate_run::{
    AskedLevel, Beginning, CanReport, Failure, Outcome, Pacing, Truth, build_with, dynamic_levels,
    exceeded, finished, header, scene_levels, stagger,
};

use super::ends::{Sensed, Watched, assemble, begin, settle};
use super::heat::Heat;
use super::loops::{Done, Shared};
use super::records::Records;
use super::warden::Wired;
use crate::clock;
use crate::interfaces::reports;
use crate::views::{STOPPED_BY_PAGE, Views, Wanted};

/// A finger by its files.
pub(super) struct Planned {
    place: Place,
    setup: Setup,
    header: Header,
    pub(super) projector: Projector,
}

/// Place, setup and header of a finger beside its loop.
type Finger = (Place, Setup, Header);

/// Every finger's loop, with its place on the grid of onsets, and the accounts of heat. Each has this setup alone.
pub(super) fn planned(
    setup: &Setup,
    alone: Vec<(Place, Setup)>,
    seed: u64,
) -> Result<(Vec<Planned>, Heat), Failure> {
    let (places, mut alone): (Vec<Place>, Vec<Setup>) = alone.into_iter().unzip();
    let heat = Heat::open(&setup.bench, &mut alone)?;
    let levels = levels(setup, seed)?;
    let responses = Responses::default();
    let plan = |(place, setup): (Place, Setup)| {
        let projector = build_with(&setup, seed, levels.clone(), &responses)?;
        let header = header(&setup, seed, &projector)?;
        Ok(Planned {
            place,
            setup,
            header,
            projector,
        })
    };
    let planned = places.into_iter().zip(alone).map(plan);
    let mut planned = planned.collect::<Result<Vec<_>, Failure>>()?;
    let loops = planned.iter_mut().map(|p| (&p.place, &mut p.projector));
    stagger(setup, loops.collect())?;
    Ok((planned, heat))
}

/// The intensity levels of a scene's own touches; without touches they are found frame by frame.
fn levels(setup: &Setup, seed: u64) -> Result<Levels, Failure> {
    let scene = &setup.scene.value;
    match scene.touches.is_empty() {
        true => Ok(dynamic_levels(&scene.compression)),
        false => scene_levels(setup, seed),
    }
}

/// A run that is about to begin: its loops and its records.
pub(super) struct Run<'a> {
    setup: &'a Setup,
    planned: Vec<Planned>,
    /// Decoded taxels of each finger, where they are recorded.
    taxels: Vec<Option<Readings>>,
    records: Records,
    signals: Signals,
    wanted: Wanted<'a>,
    started: std::time::Duration,
}

impl<'a> Run<'a> {
    /// Creates the records of fingers whose bench is not open yet.
    pub(super) fn new(
        setup: &'a Setup,
        planned: Vec<Planned>,
        signals: Signals,
        wanted: Wanted<'a>,
    ) -> Result<Self, Failure> {
        let started = clock::elapsed();
        let is_decoded = writes(wanted, Format::Mcap);
        let decoded = |p: &Planned| {
            let whole = || Readings::whole(p.projector.layout(), p.setup.scene.value.drives);
            is_decoded.then(whole)
        };
        let taxels: Vec<Option<Readings>> = planned.iter().map(decoded).collect();
        let numbered = |p: &Planned| {
            let mut header = p.header.clone();
            p.place.number_header(&mut header);
            header
        };
        let headers: Vec<Header> = planned.iter().map(numbered).collect();
        let each = planned.iter().zip(&headers).zip(&taxels);
        let each = each.map(|((p, header), own)| {
            let modules = own.as_ref().map_or(&[][..], Readings::modules);
            (&p.place, header, modules)
        });
        let tells = !wanted.quiet && !wanted.watch;
        let grow = (wanted.files, wanted.outputs);
        let records = Records::create(setup, &each.collect::<Vec<_>>(), grow, tells)?;
        Ok(Self {
            setup,
            planned,
            taxels,
            records,
            signals,
            wanted,
            started,
        })
    }

    /// Tells whether frames of sensor buses are kept.
    pub(super) fn keeps_can(&self) -> bool {
        writes(self.wanted, Format::Candump) || writes(self.wanted, Format::Mcap)
    }

    /// The fingers whose boards are to be opened.
    pub(super) fn fingers(&self) -> Vec<Wired<'_>> {
        let planned = self.planned.iter();
        let wired = planned.map(|p| Wired {
            place: &p.place,
            setup: &p.setup,
            projector: &p.projector,
        });
        wired.collect()
    }

    /// Runs the loops between these ends, for `length` or until something ends them. With several fingers `found` has
    /// the boards that the guardian found driving.
    pub(super) fn until_end<S: Sensed + Send, D: Watched + Send>(
        mut self,
        ends: Vec<(S, D)>,
        found: &str,
        clock: RunClock,
        length: Instant,
    ) -> Result<Outcome, Failure> {
        self.records.show(self.views(length)?);
        let (setup, mut records, signals) = (self.setup, self.records, self.signals);
        let watched = records.are_seen();
        let (mut fingers, mut sessions): (Vec<Finger>, Vec<_>) = (Vec::new(), Vec::new());
        for ((planned, ends), taxels) in self.planned.into_iter().zip(ends).zip(self.taxels) {
            let truth = match planned.setup.bench.value.kind {
                BenchKind::Real => Truth::Unknown,
                BenchKind::Emulated => Truth::of_scene(&planned.setup),
            };
            let driven = (planned.projector, planned.setup.scene.value.drives);
            let mut session = assemble(driven, ends, truth, taxels, watched);
            session.plan_passes(&planned.setup);
            sessions.push(session);
            fingers.push((planned.place, planned.setup, planned.header));
        }
        begin(&mut sessions, clock)?;
        let several = !setup.fingers.is_empty();
        let found = found.lines().filter(|_| several);
        let found = found.map(|line| Event::note(Instant::ZERO, format!("{line}; switched off")));
        let told = setup.told.as_ref();
        let told = told.map(|told| Event::note(Instant::ZERO, format!("hot pass: {told}")));
        let mut notes: Vec<Event> = found.chain(told).collect();
        records.add(notes.clone());
        if several {
            let begun = sessions.iter_mut().map(|s| s.recorder().events.clone());
            records.add(records.boards(&begun.collect::<Vec<_>>()));
        }
        sessions.iter_mut().for_each(|s| s.skin().begin());
        // An oscillator runs this long after its own start, whenever that was.
        clock.sleep_until(clock.now() + Duration::from_millis(1));
        let shared = Shared::new(
            setup,
            (&signals, self.wanted),
            (clock, clock.now() + length.since(Instant::ZERO)),
            watched,
        );
        let (mut done, ended) = shared.drive(sessions, &mut records)?;
        let end = done.iter().map(|done| done.end).max().unwrap_or_default();
        let by = match (done.iter().any(|done| done.is_kept), ended) {
            (true, _) => Some(STOPPED_BY_PAGE),
            (_, true) => Some("the person who watched"),
            _ => signals.caught(),
        };
        let by = by.map(|by| Event::note(end, format!("stopped by {by}")));
        let mut last: Vec<Event> = by.into_iter().collect();
        for left in done.iter_mut().filter(|done| !done.is_off) {
            // The guardian has tried meanwhile, and goes on.
            left.session.still_on();
        }
        let is_off = done.iter().all(|done| done.is_off);
        let guards = done.iter_mut().map(|done| &mut done.session);
        let booked = settle(guards, clock.now(), is_off);
        if let Err(failure) = &booked {
            last.push(Event::note(end, failure.to_string()));
        }
        last.extend(ends_of_boards(&fingers, &done));
        records.add(last.clone());
        notes.extend(last);
        let (not_recorded, written) = records.finish();
        let mut whole = whole(setup, fingers, done, notes);
        whole.summary.frames_not_recorded = not_recorded;
        let mut failures = [booked, written].into_iter().filter_map(Result::err);
        whole.failure = whole.failure.take().or_else(|| failures.next());
        whole.summary.wall_s = clock::elapsed().saturating_sub(self.started).as_secs_f64();
        Ok(whole.concluded(setup, false))
    }

    /// Live views of all fingers, one at a time.
    fn views(&self, end: Instant) -> Result<Views, Failure> {
        let mut views = Views::default();
        for finger in &self.planned {
            let run = Beginning {
                setup: &finger.setup,
                header: &finger.header,
                projector: &finger.projector,
                end,
                display: finger.place.name.as_deref(),
            };
            views.begin(self.wanted, &run)?;
        }
        Ok(views)
    }
}

/// Tells whether a file of this format grows.
fn writes(wanted: Wanted<'_>, format: Format) -> bool {
    wanted.files.iter().any(|(other, _)| *other == format)
}

/// Outcome of the whole run, with the notes of all of it.
fn whole<S: Sensed, D: Watched>(
    setup: &Setup,
    fingers: Vec<Finger>,
    mut done: Vec<Done<S, D>>,
    notes: Vec<Event>,
) -> Outcome {
    let mut lateness = Lateness::default();
    done.iter().for_each(|d| lateness.add(&d.lateness));
    let pacing = Pacing {
        turns: lateness.turns(),
        median_us: lateness.quantile_us(0.5),
        p99_us: lateness.quantile_us(0.99),
        worst_us: lateness.worst_us(),
        realtime: done.iter().all(|d| d.realtime),
    };
    let several = !setup.fingers.is_empty();
    if let (false, [only]) = (several, &mut *done) {
        only.session.recorder().events.extend(notes.iter().cloned());
    }
    let part = |((place, alone, header), done): (Finger, Done<S, D>)| Part {
        place,
        limits: *done.session.projector().guard().limits(),
        outcome: outcome(&alone, header, done),
    };
    let mut parts: Vec<Part> = fingers.into_iter().zip(done).map(part).collect();
    let mut whole = match parts.pop() {
        Some(only) if !several => only.outcome,
        last => {
            parts.extend(last);
            let can = setup.bench.value.real.as_ref();
            let can = can.map(|real| interfaces(real, &parts));
            let common = Common {
                events: notes,
                ..Common::default()
            };
            let mut whole = join(setup, parts, common);
            whole.summary.can = can.unwrap_or_default();
            whole
        }
    };
    whole.summary.pacing = Some(pacing);
    whole
}

/// Outcome of a finger.
fn outcome<S: Sensed, D: Watched>(setup: &Setup, header: Header, mut done: Done<S, D>) -> Outcome {
    let session = &mut done.session;
    let costs = session.take_costs();
    let failure = session.take_failure();
    let mut effort = Effort::new(&costs, session.traffic());
    let ledger = Ledger {
        length_us: done.end.as_micros(),
        margins: exceeded(session.projector().guard()),
        ..Ledger::default()
    };
    let (trace, mut summary) = finished(session, header, ledger, &costs, &setup.bench.value);
    let (_, projector, recorder) = session.all();
    effort.finish(projector, recorder);
    summary.felt.asked = AskedLevel::find(&setup.scene.value, projector);
    let readings = recorder.readings.take();
    let pass = PassEnd::find(projector, done.end, None);
    let names = setup.bench.value.real.as_ref().map(|real| &*real.can);
    let tallies = session.skin().tallies();
    let wires = setup.bench.value.haptics.is_none();
    summary.felt.state = wires.then(|| pass::state_of(setup));
    summary.unit = session.display().unit();
    summary.heat = session.display().heat();
    summary.can = reports(names.unwrap_or_default(), &tallies);
    Outcome {
        // Nothing measures a real finger.
        warmth: Vec::new(),
        readings,
        trace,
        summary,
        frame_us: costs.iter().map(|c| c.us).collect(),
        effort,
        can: Vec::new(),
        i2c: Vec::new(),
        sound: None,
        notes: Vec::new(),
        displays: Vec::new(),
        pass,
        failure,
    }
    .concluded(setup, false)
}

/// Ends of boards that several fingers share: one is off when the last of them is.
fn ends_of_boards<S, D>(fingers: &[Finger], done: &[Done<S, D>]) -> Vec<Event> {
    let mut boards: BTreeMap<u8, Vec<Option<u64>>> = BTreeMap::new();
    for ((place, ..), done) in fingers.iter().zip(done) {
        for board in &place.boards {
            let end = done.is_off.then_some(done.end.as_micros());
            boards.entry(*board).or_default().push(end);
        }
    }
    let off = |(board, ends): (u8, Vec<Option<u64>>)| {
        // Where one finger's wires may be on, the board is not known to be off.
        let mut ends: Vec<u64> = ends.into_iter().collect::<Option<_>>()?;
        ends.sort_unstable();
        ends.dedup();
        // With one end the fingers' own events say it.
        let t_us = *ends.last().filter(|_| ends.len() > 1)?;
        Some(Event::AllOff(event::AllOff {
            t_us,
            board,
            cause: "end",
        }))
    };
    boards.into_iter().filter_map(off).collect()
}

/// Reports of every interface: frames add up over fingers, faults of the interface were seen by all of them.
fn interfaces(real: &Real, parts: &[Part]) -> Vec<CanReport> {
    let of = |name: &String| {
        let all = parts.iter().flat_map(|p| &p.outcome.summary.can);
        let own = all.filter(|report| report.interface == *name).cloned();
        own.reduce(|sum, one| CanReport {
            frames: sum.frames + one.frames,
            lost: sum.lost + one.lost,
            overruns: sum.overruns.max(one.overruns),
            errors: sum.errors.max(one.errors),
            bus_off: sum.bus_off.max(one.bus_off),
            hardware_stamps: sum.hardware_stamps + one.hardware_stamps,
            ..sum
        })
    };
    real.can.iter().filter_map(of).collect()
}
