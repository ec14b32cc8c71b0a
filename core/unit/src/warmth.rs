//! A Peltier module on the unit: its regulator and its guard run here, and tell the wires' guard the temperature of the
//! face. A host only sends the wanted temperature.

use core::convert::Infallible;

use palpate_core::codec::link::{Face, Warmth};
use palpate_core::driver::Actuators;
use palpate_core::guard::Guard;
use palpate_core::peltier::{
    GuardedCurrent, LIMITS, PeltierReason, Reading, Regulator, UNCERTAINTY_K, Wanted,
};
use palpate_core::units::Instant;

/// A module as its unit has it: a bridge that takes what its guard has passed, and two thermistors.
pub trait Module: Actuators<GuardedCurrent> {
    /// The newest conversion of both thermistors, by the unit's clock, which shows `now`.
    fn reading(&mut self, now: Instant) -> Reading;
}

/// The module of a unit that has none. There is no value of it, so that such an image has nothing of a regulator.
#[derive(Clone, Copy, Debug)]
pub enum NoModule {}

impl Actuators<GuardedCurrent> for NoModule {
    type Error = Infallible;

    fn apply(&mut self, _: &GuardedCurrent) -> Result<(), Infallible> {
        match *self {}
    }

    fn all_off(&mut self) -> Result<(), Infallible> {
        match *self {}
    }
}

impl Module for NoModule {
    fn reading(&mut self, _: Instant) -> Reading {
        match *self {}
    }
}

/// A module, its regulator, and its host's request.
#[derive(Debug)]
pub(crate) struct Warm<T> {
    module: T,
    regulator: Regulator,
    wanted: Option<Warmth>,
    face: Face,
}

/// Degrees C of the link's millidegrees.
fn celsius(mc: u16) -> f64 {
    f64::from(mc) * 1e-3
}

/// Millidegrees C of the link; the cast saturates.
fn milli(c: f64) -> u16 {
    (c * 1e3) as u16
}

impl<T: Module> Warm<T> {
    pub(crate) const fn new(module: T, regulator: Regulator) -> Self {
        Self {
            module,
            regulator,
            wanted: None,
            face: Face {
                face_mc: 0,
                warmest_mc: 0,
                aim_mc: 0,
                sink_mc: 0,
                milliamps: 0,
                reason: Some(PeltierReason::Off),
            },
        }
    }

    /// Takes the request of the newest command.
    pub(crate) const fn want(&mut self, wanted: Option<Warmth>) {
        self.wanted = wanted;
    }

    /// Time at which the module's next turn is due, at the latest when
    /// the newest reading becomes too old for a current that flows.
    pub(crate) fn next(&self, guard: &Guard) -> Instant {
        let next = self.regulator.next();
        match self.face.milliamps {
            0 => next,
            _ => next.min(guard.stale_at()),
        }
    }

    /// Report on the module for a status.
    pub(crate) const fn face(&self) -> Face {
        self.face
    }

    /// A turn of the regulator where one is due. Nothing flows without a host whose reading is fresh, nor after a stop.
    pub(crate) fn turn(&mut self, now: Instant, guard: &mut Guard) {
        let drives = guard.latched().is_none() && guard.heard().is_some() && !guard.is_stale(now);
        if !drives && self.face.milliamps != 0 {
            // At once: a turn takes a small processor a millisecond.
            self.off();
        }
        if now < self.regulator.next() {
            return;
        }
        self.regulator.see(now, &self.module.reading(now));
        let wanted = self.wanted.filter(|_| drives);
        // The wires make room for the wanted face; the face makes room for what they have booked already.
        let reserved_c = wanted.map_or(0.0, |w| celsius(w.face_mc) + UNCERTAINTY_K);
        let warmest_c = self.regulator.warmest_c();
        let bears_c = guard.warm(now, warmest_c, reserved_c.min(LIMITS.face_c[1]));
        let turned = self.regulator.turn(
            now,
            wanted.map(|w| Wanted {
                face_c: celsius(w.face_mc),
                ceiling_c: (bears_c - UNCERTAINTY_K).min(celsius(w.ceiling_mc)),
            }),
        );
        let reached = self.module.apply(&turned.update).is_ok();
        self.face = Face {
            face_mc: turned.face_c.map_or(0, milli),
            // From above, so that a host never counts with a colder one.
            warmest_mc: milli(warmest_c).saturating_add(1),
            aim_mc: turned.aim_c.map_or(0, milli),
            sink_mc: self.regulator.sink_c().map_or(0, milli),
            milliamps: turned.update.milliamps() as i16, // its guard lets 1 A pass at most
            reason: turned.reason,
        };
        if !reached {
            self.off();
        }
    }

    /// Switches the current off until the next turn.
    pub(crate) fn off(&mut self) {
        self.face.milliamps = 0;
        // A bridge that is not reached lets go by itself.
        let _ = self.module.all_off();
    }
}
