//! Hardware that several fingers share: a skin of which each reads its own modules, the buses with their boards, and the
//! scene's faults of both.

use std::cell::RefCell;

use palpate_core::skin::{ModuleScan, TakeScan};
use palpate_core::units::Instant;
use palpate_files::{Fault, Setup};
use palpate_records::trace::Event;

use super::Run;
use crate::actuator_bus::ActuatorBus;
use crate::boards::BusReport;
use crate::effects::Faultable;
use crate::failure::Failure;
use crate::join::Common;
use crate::place::Place;
use crate::policy::TICK;
use crate::script::Script;
use crate::skin_end::SkinEnd;

/// A scan that waits for its finger's next turn.
#[derive(Debug)]
struct Held {
    module: u16,
    at: Instant,
    counts: Vec<[u16; 3]>,
    fresh: Option<Vec<bool>>,
}

/// The hardware that fingers have in common.
pub(super) struct Shared<'a> {
    skin: &'a mut dyn SkinEnd,
    pub(super) buses: Vec<ActuatorBus>,
    /// The skin's faults.
    script: Script,
    pub(super) events: Vec<Event>,
    /// Time of the next reading of the skin. No finger sets these times, so each finds what it would find alone. Onsets
    /// between two of them, of the second finger on a board, go by readings of the earlier one.
    pub(super) due: Instant,
    /// Place of every finger, and the scans of its modules that wait for it.
    pads: Vec<(Place, Vec<Held>)>,
}

impl<'a> Shared<'a> {
    /// The hardware before a run, nothing started yet.
    pub(super) fn new(run: &Run<'_>, skin: &'a mut dyn SkinEnd, alone: &[(Place, Setup)]) -> Self {
        let faults = run.setup.scene.value.faults.iter();
        let of_skin = faults.filter(|fault: &&Fault| !fault.kind.is_of_display());
        Self {
            skin,
            buses: ActuatorBus::all(run.setup, run.layout, run.seed),
            script: Script::new(of_skin, run.layout),
            events: Vec::new(),
            due: Instant::ZERO,
            pads: alone
                .iter()
                .map(|(place, _)| (place.clone(), Vec::new()))
                .collect(),
        }
    }

    /// Reads the skin, if that is due, and then does the faults that are due.
    pub(super) fn turn(&mut self, now: Instant) -> Result<(), Failure> {
        if now < self.due {
            return Ok(());
        }
        self.skin.advance_to(now);
        let pads = &mut self.pads;
        self.skin.scans(now, &mut |scan| {
            let module = usize::from(scan.module);
            // A module is one finger's.
            let mut own = pads.iter_mut();
            let own = own.find_map(|(place, held)| Some((place.own_module(module)?, held)));
            if let Some((module, held)) = own {
                held.push(Held {
                    module: module as u16, // a skin has fewer modules than that
                    at: scan.at,
                    counts: scan.counts.to_vec(),
                    fresh: scan.fresh.map(<[bool]>::to_vec),
                });
            }
        })?;
        self.fail(now, false);
        Ok(())
    }

    /// Lets faults begin and end that are due at `now`; with `last` those that are on end.
    pub(super) fn fail(&mut self, now: Instant, last: bool) {
        let mut bench = Faultable {
            skin: self.skin.emulated(),
            display: None,
        };
        let events = &mut self.events;
        self.script.step(now, last, &mut bench, events);
        let buses = self.buses.iter_mut().map(|bus| {
            bus.fail(now, last, events);
            bus.next_fault()
        });
        self.due = buses.fold(self.script.next(), Instant::min).min(now + TICK);
    }

    /// Lets the skin come to the `last` turn, and ends the faults of a run that would go on until `end`.
    pub(super) fn end(&mut self, last: Instant, end: Instant) {
        self.skin.advance_to(last);
        self.fail(end, true);
    }

    /// Events, faults and frames that fingers have in common once the run is over.
    pub(super) fn common(&mut self) -> Common {
        Common {
            events: std::mem::take(&mut self.events),
            faults: self.script.report(),
            board_faults: self.buses.iter().flat_map(ActuatorBus::faults).collect(),
            i2c: self.buses.iter().flat_map(ActuatorBus::transfers).collect(),
            can: self.skin.take_frames(),
            buses: self.skin.buses(),
        }
    }
}

/// One finger's modules of a shared skin, by its own numbers.
pub(super) struct Pads<'a, 'b> {
    shared: &'a RefCell<Shared<'b>>,
    finger: usize,
    /// Readings missing by its newest turn.
    lost: Vec<u64>,
}

impl<'a, 'b> Pads<'a, 'b> {
    /// The modules of the finger of this number.
    pub(super) fn new(shared: &'a RefCell<Shared<'b>>, finger: usize) -> Self {
        let modules = shared.borrow().pads[finger].0.modules.len();
        Self {
            shared,
            finger,
            lost: vec![0; modules],
        }
    }
}

impl SkinEnd for Pads<'_, '_> {
    fn scans(&mut self, _now: Instant, take: &mut TakeScan<'_>) -> Result<(), Failure> {
        let mut shared = self.shared.borrow_mut();
        for held in shared.pads[self.finger].1.drain(..) {
            take(&ModuleScan {
                module: held.module,
                at: held.at,
                counts: &held.counts,
                fresh: held.fresh.as_deref(),
            });
        }
        Ok(())
    }

    /// The skin that they are part of has its own time.
    fn advance_to(&mut self, _now: Instant) {
        let shared = self.shared.borrow();
        let modules = &shared.pads[self.finger].0.modules;
        for (lost, module) in self.lost.iter_mut().zip(modules) {
            *lost = shared.skin.lost_of(*module);
        }
    }

    fn start(&mut self, module: usize) {
        let mut shared = self.shared.borrow_mut();
        let module = shared.pads[self.finger].0.modules[module];
        shared.skin.start(module);
    }

    fn foreign(&self) -> u64 {
        self.shared.borrow().skin.foreign()
    }

    fn lost_of(&self, module: usize) -> u64 {
        self.lost.get(module).copied().unwrap_or(0)
    }

    fn buses(&self) -> Vec<BusReport> {
        self.shared.borrow().skin.buses()
    }
}
