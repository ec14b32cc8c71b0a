//! The display end of a run whose boards hang on a driver unit: the unit guards them, so there is no guardian here.

use std::sync::Arc;

use palpate_buses::guardian::{Armed, Latch};
use palpate_buses::lock::BusLock;
use palpate_core::driver::Driver;
use palpate_core::guard::Guarded;
use palpate_core::projector::Projector;
use palpate_core::units::Instant;
use palpate_records::trace::Event;
use palpate_run::display_end::{DisplayEnd, OutputEnable};
use palpate_run::unit::{NoLine, UnitReport};
use palpate_run::{Failure, HeatReport, RemoteHeat};

use super::ends::Watched;
use super::heat::Heat;
use crate::link::RemoteUnit;
use crate::output::note;

/// The cause of a stop for which this program wrote no other.
const ABANDONED: &str = "the run ended without a word";

/// A unit with which a session has begun.
pub struct LinkEnd {
    unit: RemoteUnit,
    /// The Peltier module that the host regulates.
    module: Option<RemoteHeat>,
    /// Accounts of heat and dose.
    heat: Arc<Heat>,
    lock: BusLock,
    /// The record of a stop, from when outputs may start.
    armed: Option<Armed>,
}

impl LinkEnd {
    /// A unit and its lock on this computer, and its module where the bench has one. Its heat is booked with `heat`.
    pub(super) fn new(
        unit: RemoteUnit,
        module: Option<RemoteHeat>,
        heat: Heat,
        lock: BusLock,
    ) -> Self {
        Self {
            unit,
            module,
            heat: Arc::new(heat),
            lock,
            armed: None,
        }
    }

    /// Keeps a stop on this computer too, until a person has looked.
    fn latch(&mut self, cause: &str) -> String {
        let name = &self.unit.place().name;
        let kept = self.armed.as_mut().map_or(Ok(()), |r| r.latch(cause, true));
        // The unit keeps it in any case, and the armed record is a stop here.
        if let Err(e) = kept {
            note(&format!(
                "unit {name}: the cause of the stop is not kept here: {e}"
            ));
        }
        format!(
            "{cause}. Look at the wearer, then clear the stop: hil off --unlatch --unit {name} --key FILE"
        )
    }

    /// Disarms the record: the run is over, and no stop unless one was latched.
    fn disarm(&self) {
        self.armed.iter().for_each(Armed::disarm);
    }
}

impl DisplayEnd for LinkEnd {
    type Update = Guarded;

    fn parts(&mut self) -> (&mut dyn Driver, &dyn OutputEnable) {
        (&mut self.unit, &NoLine)
    }

    fn before_call(&mut self, now: Instant, projector: &mut Projector, events: &mut Vec<Event>) {
        if let Some(module) = &mut self.module {
            module.turn(now, self.unit.driver(), projector, events);
        }
    }

    fn after_call(&mut self, _now: Instant, heard: Option<Instant>) {
        self.unit.tell(heard);
    }

    fn face_c(&self) -> Option<f64> {
        self.module.as_ref().and_then(RemoteHeat::face_c)
    }

    fn advance_to(&mut self, _now: Instant, events: &mut Vec<Event>) -> Result<(), Failure> {
        self.unit.hear(events);
        Ok(())
    }

    fn keep_stopped(&mut self, cause: &str) -> Failure {
        Failure::Guard(self.latch(&format!("{cause}; outputs are off and stay off")))
    }
}

impl Watched for LinkEnd {
    /// A busy machine takes longer to prepare its loop than a session lasts unheard. From here on an end without a word is a
    /// stop.
    fn meet(&mut self) -> Result<(), Failure> {
        let latch = Latch::new(self.lock.hardware());
        let armed = latch.arm(&self.lock, ABANDONED).map_err(Failure::Device)?;
        self.armed = Some(armed);
        self.unit.connect().map(drop).inspect_err(|_| self.disarm())
    }

    fn beat(&mut self, now: Instant) -> Result<(), Failure> {
        self.unit.check(now).map_err(|failure| match failure {
            Failure::Guard(cause) => Failure::Guard(self.latch(&cause)),
            other => other,
        })
    }

    fn ledger(&self) -> Option<(&Arc<Heat>, usize)> {
        Some((&self.heat, 0))
    }

    fn abandon(&mut self, _cause: &str) {
        self.disarm();
    }

    fn part(&mut self, off: Result<(), String>, failed: bool) -> Result<(), String> {
        let parted = off.and_then(|()| self.unit.end());
        self.disarm();
        match parted {
            // The first failure is the one to tell; the unit has switched off by itself.
            Err(_) if failed => Ok(()),
            parted => parted,
        }
    }

    fn unit(&self) -> Option<UnitReport> {
        self.unit.report()
    }

    fn heat(&self) -> Option<HeatReport> {
        self.module.as_ref().map(RemoteHeat::report)
    }
}
