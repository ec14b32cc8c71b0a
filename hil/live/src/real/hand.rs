//! A run of several displays on a real bench: a loop per finger, each with sockets of its own for the boards of its
//! modules. Fingers share adapters, the clock, the guardian, and nothing else.

use std::collections::BTreeMap;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicUsize};

use palpate_buses::i2c::SharedLine;
use palpate_buses::pacer::{Lateness, RunClock};
use palpate_buses::signals::Signals;
use palpate_core::driver::Banks;
use palpate_core::guard::Guard;
use palpate_core::projector::Projector;
use palpate_core::units::{Duration, Instant};
use palpate_files::{Format, Real, Setup};
use palpate_records::readings::Readings;
use palpate_records::trace::{Event, Header, event};
use palpate_run::display_end::DisplayEnd;
use palpate_run::join::{Common, Part, join};
use palpate_run::place::{Place, fingers};
use palpate_run::plan::Responses;
use palpate_run::skin_end::Tap;
use palpate_run::{
    Beginning, CanReport, Failure, Outcome, Truth, build_with, header, plan, skin, stagger,
};

use super::bench::{Interfaces, guarded, refuse_slow, watch};
use super::clocked::Clocked;
use super::ends::{Sensed, Watched, assemble};
use super::heat::Heat;
use super::loops::{Ended, RealSession, Shared};
use super::records::{Records, taxels};
use super::warden::{FingerEnd, Vote, Warden};
use super::{levels, outcome, pacing, scene_end};
use crate::views::{STOPPED_BY_PAGE, Views, Wanted, Wish};

/// A finger as files describe it.
struct Planned {
    place: Place,
    setup: Setup,
    header: Header,
    projector: Projector,
}

/// What is kept of it beside its loop.
type Finger = (Place, Setup, Header);

impl Planned {
    /// Its session, not begun, between its ends.
    fn assemble(
        self,
        ((can, end), taxels): ((Interfaces, FingerEnd), Option<Readings>),
        watched: bool,
        keeps_can: bool,
    ) -> (Finger, RealSession) {
        let skin = skin::source(
            &self.setup,
            self.projector.layout(),
            Tap::new(can, keeps_can),
        );
        let driven = (self.projector, self.setup.scene.value.drives);
        let session = assemble(driven, (skin, end), Truth::Unknown, taxels, watched);
        ((self.place, self.setup, self.header), session)
    }
}

/// Runs a scene's length on all fingers that it drives.
pub(super) fn run(
    (setup, real): (&Setup, &Real),
    seed: u64,
    signals: &Signals,
    wanted: Wanted<'_>,
) -> Result<Outcome, Failure> {
    let files = wanted.files;
    let (planned, heat) = planned(setup, seed)?;
    let whole = |p: &Planned| Readings::whole(p.projector.layout(), p.setup.scene.value.drives);
    let readings: Vec<Readings> = planned.iter().map(whole).collect();
    let numbered = |p: &Planned| {
        let mut header = p.header.clone();
        p.place.number_header(&mut header);
        header
    };
    let headers: Vec<Header> = planned.iter().map(numbered).collect();
    let each = planned.iter().zip(&headers).zip(&readings);
    let each = each.map(|((p, header), r)| (&p.place, header, r.modules()));
    let tells = !wanted.quiet && !wanted.watch;
    let grow = (files, wanted.outputs);
    let mut records = Records::create(setup, &each.collect::<Vec<_>>(), grow, tells)?;
    let taxels = readings.into_iter().map(|all| taxels(files, all));
    let taxels: Vec<Option<Readings>> = taxels.collect();
    let watched = wanted.is_seen();
    if watched {
        records.show(shown(&planned, scene_end(setup), wanted)?);
    }
    let (clock, warden, ends, found) = open((setup, real), heat, &planned)?;
    let keeps_can = files
        .iter()
        .any(|(format, _)| matches!(format, Format::Candump | Format::Mcap));
    let ends = ends.into_iter().zip(taxels);
    let assembled = planned.into_iter().zip(ends);
    let assembled = assembled.map(|(planned, ends)| planned.assemble(ends, watched, keeps_can));
    let (fingers, mut sessions): (Vec<_>, Vec<_>) = assembled.unzip();
    let mut notes: Vec<Event> = found
        .lines()
        .map(|line| Event::note(Instant::ZERO, format!("{line}; switched off")))
        .collect();
    start(&mut sessions, &warden, clock)?;
    let begun: Vec<Vec<Event>> = sessions
        .iter_mut()
        .map(|s| s.recorder().events.clone())
        .collect();
    records.add(notes.clone());
    records.add(records.boards(&begun));
    let now = clock.now();
    let shared = Shared {
        real,
        warden: &warden,
        signals,
        clock,
        end: Instant::from_micros(scene_end(setup).as_micros().saturating_add(now.as_micros())),
        over: AtomicBool::new(false),
        ready: AtomicUsize::new(0),
        go: AtomicBool::new(false),
        watched,
    };
    let (mut done, stopped) = shared.drive(sessions, &mut records)?;
    if let Some(by) = stopped.map(Wish::by).or_else(|| signals.caught()) {
        notes.push(Event::note(clock.now(), format!("stopped by {by}")));
    }
    let parted = part(&fingers, &mut done, &warden, stopped);
    if let Err(cause) = &parted {
        let text = format!("not everything is known to be off: {cause}");
        notes.push(Event::note(clock.now(), text));
    }
    let guards = states(done.iter().map(|(done, _)| &done.session), clock.now());
    let booked = warden.heat.end(&guards, parted.is_ok());
    if let Err(failure) = &booked {
        notes.push(Event::note(clock.now(), failure.to_string()));
    }
    notes.extend(ends_of_boards(&fingers, &done));
    records.add(notes[found.lines().count()..].to_vec());
    let (not_recorded, written) = records.finish();
    let failures = [parted.map_err(Failure::Device), booked, written];
    let mut whole = joined((setup, real), fingers, done, notes);
    whole.summary.frames_not_recorded = not_recorded;
    let mut failures = failures.into_iter().filter_map(Result::err);
    whole.failure = whole.failure.take().or_else(|| failures.next());
    Ok(whole.concluded(setup, false))
}

/// The run on paper.
fn joined(
    (setup, real): (&Setup, &Real),
    fingers: Vec<Finger>,
    done: Vec<Ended>,
    notes: Vec<Event>,
) -> Outcome {
    let mut lateness = Lateness::default();
    done.iter().for_each(|(d, _)| lateness.add(&d.lateness));
    let realtime = done.iter().all(|(d, _)| d.realtime);
    let part = |((place, alone, header), (done, _)): (Finger, Ended)| Part {
        place,
        limits: *done.session.projector().guard().limits(),
        outcome: outcome(&alone, header, done),
    };
    let parts: Vec<Part> = fingers.into_iter().zip(done).map(part).collect();
    let can = interfaces(real, &parts);
    let common = Common {
        events: notes,
        ..Common::default()
    };
    let mut whole = join(setup, parts, common);
    whole.summary.can = can;
    whole.summary.pacing = Some(pacing(&lateness, realtime));
    whole
}

/// Every finger's loop, with its place on the grid of onsets, and what heat is booked with.
fn planned(setup: &Setup, seed: u64) -> Result<(Vec<Planned>, Heat), Failure> {
    let (places, mut alone): (Vec<Place>, Vec<Setup>) = fingers(setup).into_iter().unzip();
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
    for finger in &planned {
        let real = setup.bench.value.real.as_ref();
        real.map_or(Ok(()), |real| refuse_slow(real, finger.projector.guard()))?;
    }
    Ok((planned, heat))
}

/// Live views of all fingers, one at a time.
fn shown(planned: &[Planned], end: Instant, wanted: Wanted<'_>) -> Result<Views, Failure> {
    let mut views = Views::default();
    for finger in planned {
        let run = Beginning {
            setup: &finger.setup,
            header: &finger.header,
            projector: &finger.projector,
            end,
            display: Some(finger.place.display()),
        };
        views.begin(wanted, &run)?;
    }
    Ok(views)
}

/// The clock, the guardian, the ends of every finger, and what the guardian found driving.
type Opened = (RunClock, Arc<Warden>, Vec<(Interfaces, FingerEnd)>, String);

/// Opens everything, guardian last: from then on it can say off.
fn open(
    (setup, real): (&Setup, &Real),
    heat: Heat,
    planned: &[Planned],
) -> Result<Opened, Failure> {
    // Displays that the scene does not drive are the guardian's as well.
    let watch = watch(&setup.bench.value, real);
    let clock = RunClock::start();
    let skins = planned
        .iter()
        .map(|p| Interfaces::of_boards(real, p.projector.layout(), clock));
    let skins: Vec<Interfaces> = skins.collect::<Result<_, _>>()?;
    let (lines, guardian, found) = guarded(&watch)?;
    let has_oe = real.oe.is_some();
    let warden = Arc::new(Warden::new(guardian, heat, planned.len(), has_oe));
    let mut ends: Vec<(usize, FingerEnd)> = Vec::new();
    for (bus, line) in lines.into_iter().enumerate() {
        let on = planned.iter().enumerate();
        let on = on
            .filter(|(_, p)| usize::from(p.place.bus) == bus)
            .map(|(finger, _)| finger);
        let on: Vec<usize> = on.collect();
        let shares = SharedLine::share(line, warden.pulse(), warden.round(), &on);
        for (finger, share) in on.into_iter().zip(shares) {
            let Planned {
                place,
                setup,
                projector,
                ..
            } = &planned[finger];
            let boards = plan::boards(&setup.bench.value);
            let banks = Banks::new([(share, &*boards)], projector.guard().prescale());
            let banks = plan::with_converters(&setup.bench.value, banks);
            let banks = match place.alone {
                true => banks,
                false => banks.sharing(&place.channels),
            };
            let vote = Vote {
                warden: Arc::clone(&warden),
                finger,
            };
            let adapters = watch.buses.iter().map(|bus| bus.path.clone());
            let end = FingerEnd {
                banks: Clocked::new(banks, clock),
                vote,
                name: place.display().to_owned(),
                adapters: adapters.collect(),
                stopped: None,
            };
            ends.push((finger, end));
        }
    }
    ends.sort_by_key(|(finger, _)| *finger);
    let ends = skins.into_iter().zip(ends.into_iter().map(|(_, end)| end));
    Ok((clock, warden, ends.collect(), found))
}

/// The guards of all fingers, at a time of the run.
fn states<'a>(
    sessions: impl Iterator<Item = &'a RealSession>,
    now: Instant,
) -> Vec<(Instant, &'a Guard)> {
    let guards = sessions.map(|session| session.projector().guard());
    guards.map(|guard| (now, guard)).collect()
}

/// Heat reserved, everything off and set up, on all fingers; no loop turns before.
fn start(sessions: &mut [RealSession], warden: &Warden, clock: RunClock) -> Result<(), Failure> {
    // The same time for all: what boards have in common is told once.
    let now = clock.now();
    let held = warden.heat.begin(&states(sessions.iter(), now));
    held.inspect_err(|_| {
        // Nothing is on yet: the good-bye cannot fail in a way that matters more than this.
        let _ = warden.part(None, None);
    })?;
    let started = sessions.iter_mut().try_for_each(|session| {
        session.start(now).map(drop).map_err(|error| {
            let cause = session.display().explain(&error);
            session.display().abandon(&cause);
            Failure::Device(cause)
        })
    });
    started.inspect_err(|_| {
        // Nothing was driven. What cannot be booked of that stays reserved.
        let _ = warden.heat.end(&states(sessions.iter(), now), true);
    })?;
    for session in sessions {
        session.skin().begin();
    }
    // An oscillator runs this long after its own start, whenever that was.
    clock.sleep_until(clock.now() + Duration::from_millis(1));
    Ok(())
}

/// The run's good-bye to the guardian.
fn part(
    fingers: &[Finger],
    done: &mut [Ended],
    warden: &Warden,
    wish: Option<Wish>,
) -> Result<(), String> {
    let (mut left, mut stopped) = (Vec::new(), Vec::new());
    for ((place, ..), (done, on)) in fingers.iter().zip(done.iter_mut()) {
        if wish == Some(Wish::Stop) {
            let kept = done.session.display().keep_stopped(STOPPED_BY_PAGE);
            done.session.set_failure(kept);
        }
        let named = |cause: &String| format!("{}: {cause}", place.display());
        left.extend(on.as_ref().map(named));
        stopped.extend(done.session.display().stopped.as_ref().map(named));
    }
    let said = |causes: Vec<String>| (!causes.is_empty()).then(|| causes.join("; "));
    let parted = warden.part(said(left).as_deref(), said(stopped).as_deref());
    for (done, _) in done.iter_mut().filter(|(_, on)| on.is_some()) {
        // The guardian has tried meanwhile, and goes on.
        done.session.still_on();
    }
    parted
}

/// A board that several fingers share is off when the last of them is.
fn ends_of_boards(fingers: &[Finger], done: &[Ended]) -> Vec<Event> {
    let mut boards: BTreeMap<u8, Vec<Option<u64>>> = BTreeMap::new();
    for ((place, ..), (done, on)) in fingers.iter().zip(done) {
        for board in &place.boards {
            let end = on.is_none().then_some(done.end.as_micros());
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

/// What has come over every interface: frames are each finger's own, what befell the interface all of them saw.
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
