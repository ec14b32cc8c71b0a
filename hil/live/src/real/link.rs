//! The display end of a run whose boards hang on a driver unit: the unit guards them, so there is no guardian here.

use palpate_core::driver::Driver;
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

/// A unit with which a session has begun, what the host does about its Peltier module, and what heat is booked with.
pub struct LinkEnd(RemoteUnit, Option<RemoteHeat>, Heat);

impl LinkEnd {
    /// A unit, and its module where the bench has one.
    pub(super) const fn new(unit: RemoteUnit, module: Option<RemoteHeat>, heat: Heat) -> Self {
        Self(unit, module, heat)
    }

    /// Keeps a stop on this computer too, until a person has looked.
    fn latch(&self, cause: &str) -> String {
        let place = self.0.place();
        // The unit keeps it in any case.
        if let Err(e) = place.latch().set(cause, true) {
            note(&format!(
                "unit {}: the stop is not kept here: {e}",
                place.name
            ));
        }
        format!(
            "{cause}. Look at the wearer, then clear the stop: hil off --unlatch --unit {} --key FILE",
            place.name
        )
    }
}

impl DisplayEnd for LinkEnd {
    fn parts(&mut self) -> (&mut dyn Driver, &dyn OutputEnable) {
        (&mut self.0, &NoLine)
    }

    fn before_call(&mut self, now: Instant, projector: &mut Projector, events: &mut Vec<Event>) {
        if let Some(heat) = &mut self.1 {
            heat.turn(now, self.0.driver(), projector, events);
        }
    }

    fn after_call(&mut self, _now: Instant, heard: Option<Instant>) {
        self.0.tell(heard);
    }

    fn advance_to(&mut self, _now: Instant, events: &mut Vec<Event>) -> Result<(), Failure> {
        self.0.hear(events);
        Ok(())
    }

    fn keep_stopped(&mut self, cause: &str) -> Failure {
        Failure::Guard(self.latch(&format!("{cause}; outputs are off and stay off")))
    }
}

impl Watched for LinkEnd {
    /// A busy machine takes longer to prepare its loop than a session lasts unheard.
    fn meet(&mut self) -> Result<(), Failure> {
        self.0.connect().map(drop)
    }

    fn beat(&mut self, now: Instant) -> Result<(), Failure> {
        self.0.check(now).map_err(|failure| match failure {
            Failure::Guard(cause) => Failure::Guard(self.latch(&cause)),
            other => other,
        })
    }

    fn ledger(&self) -> Option<(&Heat, usize)> {
        Some((&self.2, 0))
    }

    fn abandon(&mut self, _cause: &str) {}

    fn part(&mut self, off: Result<(), String>, failed: bool) -> Result<(), String> {
        match off.and_then(|()| self.0.end()) {
            // The first failure is the one to tell; the unit has switched off by itself.
            Err(_) if failed => Ok(()),
            parted => parted,
        }
    }

    fn unit(&self) -> Option<UnitReport> {
        self.0.report()
    }

    fn heat(&self) -> Option<HeatReport> {
        self.1.as_ref().map(RemoteHeat::report)
    }
}
