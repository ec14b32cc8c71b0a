//! Everything off: the request, the confirmation, and the way back.

use crate::driver::Actuators;
use crate::units::{Board, Duration, Instant};

use super::update::Update;
use super::{Cause, Observer, Output};

impl Output {
    /// Resets the output after a stop: nothing is driven after [`Self::all_off`],
    /// whatever its cause, until this has been called once the cause is gone. The
    /// source is alive, the calls were on time, and all outputs take an all-off.
    ///
    /// # Errors
    /// [`Cause`] that still stands; everything stays off. [`Cause::Overrun`] says that this all-off came too late.
    pub fn reset<U: Update, A: Actuators<U> + ?Sized>(
        &mut self,
        now: Instant,
        actuators: &mut A,
        observer: &mut impl Observer,
    ) -> Result<(), Cause> {
        // The outputs last: while another cause stands there is no need to trouble their bus.
        self.guard.ready(now)?;
        actuators.all_off().map_err(|_| Cause::ActuatorError)?;
        if self.settle(actuators.confirmed(now), observer) {
            return Err(Cause::Overrun);
        }
        self.guard.reset(now)
    }

    /// Switches everything off, now, and keeps it off until [`Self::reset`]. What could not be switched off counts as
    /// on until [`Self::settle`] or an all-off that succeeds.
    ///
    /// # Errors
    /// Error of the first board that did not answer.
    pub fn all_off<U: Update, A: Actuators<U> + ?Sized>(
        &mut self,
        now: Instant,
        cause: Cause,
        actuators: &mut A,
        observer: &mut impl Observer,
    ) -> Result<(), A::Error> {
        self.guard.ask_off(now);
        let off = actuators.all_off();
        self.guard.latch(cause);
        match off {
            Ok(()) => {
                let at = actuators.confirmed(now);
                self.settle(at, observer);
                self.off(at, cause, observer);
            }
            Err(_) => {
                self.unsettled.get_or_insert(cause);
            }
        }
        off
    }

    /// Settles that everything is known to be off since `at` by another way than the
    /// driver's: its outputs are cut, or its boards were started anew. It does nothing
    /// where all is known to be off. Returns whether a wire was on for too long meanwhile.
    pub fn settle(&mut self, at: Instant, observer: &mut impl Observer) -> bool {
        let cause = self.unsettled.take();
        cause.is_some_and(|cause| self.off(at, cause, observer))
    }

    /// Counts what is on at `now` as on for `span` longer than the clock says, since the machine slept, and from then
    /// on until it is known to be off.
    pub fn slept(&mut self, now: Instant, span: Duration) {
        self.guard.ask_off(now);
        self.guard.still_on(now + span);
    }

    /// Counts what is not known to be off as on until `at`; it may still be on.
    pub fn still_on(&mut self, at: Instant) {
        self.guard.still_on(at);
    }

    /// Tells the guard and the observer that everything is off since `at`. Returns whether that was too late.
    fn off(&mut self, at: Instant, cause: Cause, observer: &mut impl Observer) -> bool {
        self.guard.all_off(at);
        let overran = self.guard.overran();
        let cause = match overran {
            true => cause.followed_by(Cause::Overrun),
            false => cause,
        };
        if overran {
            self.guard.latch(Cause::Overrun);
        }
        for board in 0..=self.boards {
            observer.all_off(at, Board(board), cause);
        }
        overran
    }
}

#[cfg(test)]
#[path = "stop_tests.rs"]
mod tests;
