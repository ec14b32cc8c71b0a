//! Joins the fingers of a run: one trace and one summary, in the numbers of bench and scene.

use std::collections::BTreeSet;

use palpate_core::bus::Received;
use palpate_core::guard::Limits;
use palpate_files::{Finger, Setup};
use palpate_records::frame_time::FrameTime;
use palpate_records::i2c::Transfer;
use palpate_records::margin::{Limited, Margin, sort};
use palpate_records::trace::{Event, Ledger, Trace, event, sort_by_time};

use crate::boards::BusReport;
use crate::effort::Effort;
use crate::failure::Failure;
use crate::margins::against;
use crate::numbers::{joined_header, whole_boards};
use crate::onsets::Onsets;
use crate::path_error::PathError;
use crate::place::Place;
use crate::script::FaultReport;
use crate::summary::{DisplaySummary, Summary, Taxels};
use crate::{DisplayOutcome, Outcome};

/// A finger's run, in its own numbers.
#[derive(Debug)]
pub struct Part {
    /// Place of the finger's display on the bench.
    pub place: Place,
    /// Limits of the finger's guard.
    pub limits: Limits,
    /// Outcome of the finger's run.
    pub outcome: Outcome,
}

/// Events, faults and frames that all fingers share.
#[derive(Debug, Default)]
pub struct Common {
    /// Notes of the skin's faults.
    pub events: Vec<Event>,
    /// Reports of the skin's faults.
    pub faults: Vec<FaultReport>,
    /// Reports of the faults of boards and their buses, bus by bus.
    pub board_faults: Vec<FaultReport>,
    /// Transfers that crossed the boards' buses; empty where none are kept.
    pub i2c: Vec<Transfer>,
    /// Frames on the sensor buses, if they were kept.
    pub can: Vec<Received>,
    /// The sensor buses, where they are emulated.
    pub buses: Vec<BusReport>,
}

impl Part {
    fn name(&self) -> &str {
        self.place.display()
    }

    /// Numbers boards and modules as bench and skin do; wires stay the display's own.
    fn renumber(&mut self) {
        let place = &self.place;
        place.number_header(&mut self.outcome.trace.header);
        let events = self.outcome.trace.events.iter_mut();
        events.for_each(|event| place.number(event));
        let of_module = |own: usize| place.modules.get(own).copied().unwrap_or(own);
        let summary = &mut self.outcome.summary;
        summary
            .boards
            .iter_mut()
            .for_each(|b| b.module = of_module(b.module));
        summary
            .taxels
            .ill
            .iter_mut()
            .for_each(|t| t.module = of_module(t.module));
    }

    /// Most current of its supply at one instant, A.
    fn peak_a(&self) -> f64 {
        self.outcome.summary.peak_supply_a.unwrap_or(0.0)
    }
}

/// Joins the fingers' runs.
pub fn join(setup: &Setup, mut parts: Vec<Part>, common: Common) -> Outcome {
    parts.iter_mut().for_each(Part::renumber);
    let mut events = common.events.clone();
    let each = parts.iter().map(|p| (&p.place, &*p.outcome.trace.events));
    events.extend(whole_boards(&each.collect::<Vec<_>>()));
    for part in &parts {
        // Joints are the hand's: every finger has them alike.
        let own = part.outcome.trace.events.iter();
        let own = own.filter(|e| part.place == parts[0].place || !matches!(e, Event::Joint(_)));
        events.extend(own.filter_map(|e| part.place.joined(e)));
    }
    sort_by_time(&mut events);
    let ledger = ledger(setup, &parts);
    let each = parts.iter().map(|p| (&p.place, &p.outcome.trace.header));
    let header = joined_header(setup, &each.collect::<Vec<_>>());
    let mut summary = summary(&parts, &ledger, &common);
    summary.bench.clone_from(&header.bench);
    let mut i2c = common.i2c;
    i2c.sort_by_key(|t| t.start_ns);
    Outcome {
        trace: Trace {
            header,
            events,
            ledger,
        },
        summary,
        frame_us: all(&parts, |o| o.frame_us.clone()),
        warmth: Vec::new(),
        effort: Effort::sum(parts.iter().map(|p| &p.outcome.effort)),
        failure: parts.iter().find_map(failed),
        can: common.can,
        i2c,
        sound: None,
        readings: None,
        notes: Vec::new(),
        pass: None,
        displays: parts
            .into_iter()
            .map(|part| DisplayOutcome {
                name: part.name().to_owned(),
                outcome: part.outcome,
            })
            .collect(),
    }
}

fn all<T>(parts: &[Part], of: impl Fn(&Outcome) -> Vec<T>) -> Vec<T> {
    parts.iter().flat_map(|p| of(&p.outcome)).collect()
}

/// A finger's failure, with the finger's name.
fn failed(part: &Part) -> Option<Failure> {
    let failure = part.outcome.failure.as_ref()?;
    let text = format!("display `{}`: {failure}", part.name());
    Some(match failure {
        Failure::Guard(_) => Failure::Guard(text),
        _ => Failure::Device(text),
    })
}

fn ledger(setup: &Setup, parts: &[Part]) -> Ledger {
    let mut sum = Ledger::default();
    for part in parts {
        let own = &part.outcome.trace.ledger;
        sum.driven.stimuli += own.driven.stimuli;
        sum.driven.limiter_events += own.driven.limiter_events;
        sum.driven.widest = sum.driven.widest.max(own.driven.widest);
        sum.energy_uj += own.energy_uj;
        sum.length_us = sum.length_us.max(own.length_us);
        let first = part.place.first_wire as u16;
        let hottest = own.hottest_wire.map(|(t, wire)| (t, first + wire));
        sum.hottest_wire = sum.hottest_wire.max(hottest);
        sum.tight |= own.tight;
        for margin in &own.margins {
            match sum.margins.iter_mut().find(|m| m.of == margin.of) {
                Some(worst) if worst.worst() < margin.worst() => *worst = *margin,
                Some(_) => {}
                None => sum.margins.push(*margin),
            }
        }
    }
    let supply = setup.bench.value.drive.supply_limit_ma * 1e-3;
    for margin in sum
        .margins
        .iter_mut()
        .filter(|m| m.of == Limited::SupplyCurrent)
    {
        *margin = Margin::new(margin.of, peak_supply_a(parts), supply);
    }
    if sum.margin(Limited::FingertipPower60s).is_none() {
        sort(&mut sum.margins);
        return sum; // a real bench, where nothing measures them
    }
    let hand = (Limited::HandPower60s, hand_power_mw(setup, parts));
    sum.margins
        .extend(against(&setup.limits.value.limits, [hand]));
    sort(&mut sum.margins);
    sum
}

/// Largest mean power that a hand can have taken over a minute, mW: as if the worst minutes of its fingertips were the
/// same one.
fn hand_power_mw(setup: &Setup, parts: &[Part]) -> f64 {
    let worst_mw = |part: &Part| {
        let margins = part.outcome.trace.ledger.margins.iter();
        let mut tip = margins.filter(|m| m.of == Limited::FingertipPower60s);
        tip.next().map_or(0.0, Margin::worst)
    };
    let of_hand = |one: &Finger| -> f64 {
        let fingers = setup.fingers.iter().zip(parts);
        let same = fingers.filter(|(finger, _)| finger.hand == one.hand);
        same.map(|(_, part)| worst_mw(part)).sum()
    };
    setup.fingers.iter().map(of_hand).fold(0.0, f64::max)
}

/// The most that the supply may have given: boards run asynchronously, so the peaks of all of them add.
fn peak_supply_a(parts: &[Part]) -> f64 {
    let boards: BTreeSet<u8> = parts.iter().flat_map(|p| p.place.boards.clone()).collect();
    let of_board = |board: u8| {
        let on = parts.iter().filter(|p| p.place.boards.contains(&board));
        // The peak of a display on several boards is that of all of them together.
        on.map(|p| p.peak_a() / p.place.boards.len() as f64)
            .fold(0.0, f64::max)
    };
    boards.into_iter().map(of_board).sum()
}

/// Summary of all fingers. Path and felt level are those of the display with the largest error; sums and maxima are
/// over all.
fn summary(parts: &[Part], ledger: &Ledger, common: &Common) -> Summary {
    let each = || parts.iter().map(|p| &p.outcome.summary);
    let rmse = |e: &Option<PathError>| e.as_ref().map_or(f64::NEG_INFINITY, |e| e.rmse);
    let farthest = |of: fn(&Summary) -> &Option<PathError>| {
        let mut all: Vec<&Summary> = each().collect();
        all.sort_by(|a, b| rmse(of(b)).total_cmp(&rmse(of(a))));
        all[0]
    };
    let mut sum = farthest(|s| &s.felt.error_energy_mm).clone();
    sum.path_error_mm = farthest(|s| &s.path_error_mm).path_error_mm;
    sum.onsets = Onsets::default();
    each().for_each(|s| sum.onsets.join(&s.onsets));
    sum.frames = each().map(|s| s.frames).max().unwrap_or(0);
    sum.contacts = each().map(|s| s.contacts).sum();
    sum.stimuli = ledger.driven.stimuli;
    sum.limiter_events = ledger.driven.limiter_events;
    // Each display has a summary of its own textures.
    sum.texture = None;
    // Figures that no instrument measures on a real bench are in no sum either.
    let is_measured = each().any(|s| s.energy_mj.is_some());
    sum.energy_mj = is_measured.then_some(ledger.energy_uj as f64 * 1e-3);
    sum.peak_supply_a = is_measured.then(|| peak_supply_a(parts));
    sum.hottest_wire_c = ledger.hottest_wire.map(|(t, _)| f64::from(t) * 1e-3);
    let hottest = each().filter_map(|s| s.hottest_skin_c);
    sum.hottest_skin_c = hottest.reduce(f64::max);
    let sessions = each().filter_map(|s| s.longest_session_s);
    sum.longest_session_s = sessions.reduce(f64::min);
    sum.margins.clone_from(&ledger.margins);
    sum.frame_us = FrameTime::summarise(parts.iter().flat_map(|p| &p.outcome.frame_us).copied());
    sum.boards = each().flat_map(|s| s.boards.clone()).collect();
    sum.boards.sort_unstable_by_key(|b| b.module);
    sum.taxels = Taxels::joined(
        parts
            .iter()
            .map(|p| (&*p.place.modules, &p.outcome.summary.taxels)),
    );
    sum.buses.clone_from(&common.buses);
    sum.faults = faults(parts, common);
    sum.displays = parts.iter().map(of_display).collect();
    sum
}

/// Faults of the skin, then of the displays: one that meets several buses is one fault.
fn faults(parts: &[Part], common: &Common) -> Vec<FaultReport> {
    let mut all = common.faults.clone();
    let mut met: Vec<FaultReport> = Vec::new();
    let of_wires = parts.iter().flat_map(|p| &p.outcome.summary.faults);
    for report in common.board_faults.iter().chain(of_wires) {
        let same = |r: &&mut FaultReport| (&r.what, r.at_s) == (&report.what, report.at_s);
        match met.iter_mut().find(same) {
            Some(first) => first.count += report.count,
            None => met.push(report.clone()),
        }
    }
    all.append(&mut met);
    all
}

fn of_display(part: &Part) -> DisplaySummary {
    let summary = &part.outcome.summary;
    let offs = part.outcome.trace.each::<event::AllOff>();
    let stops: BTreeSet<(u64, &str)> = offs
        .filter(|off| !["start", "end"].contains(&off.cause))
        .map(|off| (off.t_us, off.cause))
        .collect();
    DisplaySummary {
        name: part.name().to_owned(),
        modules: part.place.modules.clone(),
        boards: part.place.boards.clone(),
        path_error_mm: summary.path_error_mm,
        onsets: summary.onsets,
        felt: summary.felt.clone(),
        stimuli: summary.stimuli,
        limiter_events: summary.limiter_events,
        hottest_skin_c: summary.hottest_skin_c,
        texture: summary.texture.clone(),
        supply_share_a: f64::from(part.limits.supply.0) * 1e-3,
        stops: stops.len() as u64,
        failure: part.outcome.failure.as_ref().map(ToString::to_string),
    }
}
