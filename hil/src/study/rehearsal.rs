//! Stimuli from rest and alone, on an emulated bench: what each comes to at most, before it is played on anyone.

use std::collections::{BTreeMap, BTreeSet};

use palpate_core::contact::Levels;
use palpate_core::guard::{Booked, Guard};
use palpate_core::schedule::Entry;
use palpate_core::units::Duration;
use palpate_files::{Setup, TaskKind};
use palpate_records::measure::length_us;
use palpate_records::trace::{Event, Trace, event};
use palpate_run::{Failure, Input, Keep, build, run_with};
use palpate_study::{Path, Sensed, Stimulus};

use super::stimuli::Stimuli;

/// Time between two points of a path that is known from its scene, s.
const STEP_S: f64 = 0.02;
/// Seed of what an emulated bench draws.
const SEED: u64 = 1;

/// A stimulus as it was rehearsed.
#[derive(Debug, Clone)]
pub(super) struct Rehearsed {
    /// Bookings of the guard, each with its wire.
    pub(super) bursts: Vec<(u16, Booked)>,
    /// Length of the stimulus.
    pub(super) length: Duration,
    /// Path of the contact.
    pub(super) path: Path,
    /// Onsets as the bench's person feels them.
    pub(super) sensed: Vec<Sensed>,
    /// Level of the strongest onset, dB over the threshold of the bench's person; `None` where no person wears it.
    strength_db: Option<f64>,
}

/// Stimuli that were rehearsed so far, each once.
#[derive(Debug, Clone, Default)]
pub struct Rehearsals(Vec<(Stimulus, Rehearsed)>);

impl Rehearsals {
    /// Rehearsal of a stimulus; it is played if it was not before.
    ///
    /// # Errors
    /// [`Failure`] of a bench that cannot play it.
    pub(super) fn rehearsal(
        &mut self,
        stimuli: &Stimuli,
        stimulus: &Stimulus,
    ) -> Result<&Rehearsed, Failure> {
        let found = self.0.iter().position(|(other, _)| other == stimulus);
        let place = match found {
            Some(place) => place,
            None => {
                let rehearsed = Rehearsed::new(stimuli, stimulus)?;
                self.0.push((stimulus.clone(), rehearsed));
                self.0.len() - 1
            }
        };
        Ok(&self.0[place].1)
    }
}

impl Rehearsed {
    /// Plays a stimulus as fast as it can.
    fn new(stimuli: &Stimuli, stimulus: &Stimulus) -> Result<Self, Failure> {
        let setup = stimuli.emulated(stimulus)?;
        let outcome = run_with(&setup, &Input::Scene, SEED, Keep::default(), &mut ())?;
        let trace = &outcome.trace;
        let projector = build(&setup, 1, Levels::Off)?;
        Ok(Self {
            bursts: bursts(projector.guard(), trace),
            length: Duration::from_micros(length_us(trace)),
            path: path(&setup, &trace.events),
            sensed: sensed(&trace.events),
            strength_db: trace
                .each()
                .filter_map(|onset: &event::Felt| Some(1e-3 * f64::from(onset.met?.level_mdb)))
                .reduce(f64::max),
        })
    }
}

/// Distance of the levels at which [`growth`] plays a wire, dB.
const LEVEL_STEP_DB: f64 = 2.0;
/// Number of those levels below full drive: down to the least that a session plays.
const LEVEL_STEPS: u32 = 20;

/// Strength of each wire whose levels a protocol asks for, as the bench's person feels it: dB of full drive, ascending, and dB
/// over threshold.
///
/// # Errors
/// [`Failure`] of a bench that cannot play a wire.
pub fn growth(stimuli: &Stimuli) -> Result<BTreeMap<u16, Vec<[f64; 2]>>, Failure> {
    let protocol = &stimuli.protocol().value;
    let asked = [TaskKind::AbsoluteThreshold, TaskKind::Matching];
    let wires = asked.iter().flat_map(|task| protocol.wires(*task));
    let reference = protocol.matching.iter().map(|task| &task.reference);
    let wires: BTreeSet<u16> = wires.chain(reference).copied().collect();
    let of_wire = |wire: u16| {
        let mut felt = Vec::new();
        for step in (0..=LEVEL_STEPS).rev() {
            let level_db = -LEVEL_STEP_DB * f64::from(step);
            let rehearsed = Rehearsed::new(stimuli, &Stimulus::Wire { wire, level_db })?;
            felt.extend(rehearsed.strength_db.map(|strength| [level_db, strength]));
        }
        Ok((wire, felt))
    };
    wires.into_iter().map(of_wire).collect()
}

/// The bursts of a run, as its guard booked them, with their wires.
pub(super) fn bursts(guard: &Guard, trace: &Trace) -> Vec<(u16, Booked)> {
    let entries = trace.each().filter(|entry: &&Entry| entry.off > entry.on);
    let mut bursts = Vec::new();
    for (wire, own) in (0..).zip(&trace.header.wires) {
        let of_wire = entries
            .clone()
            .filter(|entry| (entry.board.0, entry.channel.0) == (own.board, own.channel));
        bursts.extend(guard.booked(of_wire).map(|booked| (wire, booked)));
    }
    bursts
}

/// True path of a run's contact: by its strokes, or by what touched the emulated skin.
pub(super) fn path(setup: &Setup, events: &[Event]) -> Path {
    let strokes = &setup.scene.value.strokes;
    let mut path = Path::new();
    for stroke in strokes {
        let steps = (stroke.length_s / STEP_S).ceil().max(1.0) as u32;
        path.extend((0..=steps).map(|step| {
            let way = f64::from(step) / f64::from(steps);
            let at = |axis: usize| {
                stroke.from_mm[axis] + way * (stroke.to_mm[axis] - stroke.from_mm[axis])
            };
            [stroke.start_s + way * stroke.length_s, at(0), at(1)]
        }));
    }
    if strokes.is_empty() {
        let target = |onset: &event::Felt| {
            let [x, y] = [onset.target.x, onset.target.y].map(|um| f64::from(um) * 1e-3);
            [onset.t_us as f64 * 1e-6, x, y]
        };
        path.extend(event::each(events).map(target));
    }
    path
}

/// Onsets of a run as the bench's person feels them: at the centroid of energy, and nowhere below the threshold. None where no
/// person wears the bench.
pub(super) fn sensed(events: &[Event]) -> Vec<Sensed> {
    let mm = |um: i32| f64::from(um) * 1e-3;
    let onset = |onset: &event::Felt| Sensed {
        t_s: onset.t_us as f64 * 1e-6,
        place_mm: (onset.met.filter(event::FeltAt::is_felt))
            .map(|met| [mm(met.energy.x), mm(met.energy.y)]),
    };
    event::each(events).map(onset).collect()
}
