//! Where the output half sends what is due: through the guard to a driver, or past it to emulated registers while it
//! looks on.

use crate::driver::{Actuators, ObservedRegisters};
use crate::guard::Guard;
use crate::schedule::{Entry, Stimulus};
use crate::units::{Board, Instant};

/// One of the two ways.
pub(super) trait Outlet {
    type Error;
    /// Whether a stop of the guard switches off.
    const STOPS: bool;

    /// The stimuli of one board.
    fn send(
        &mut self,
        guard: &mut Guard,
        at: Instant,
        board: Board,
        stimuli: &[Stimulus],
        ledger: impl FnMut(Entry),
    ) -> Result<(), Self::Error>;

    /// Ends what has ended on one board.
    fn expire(&mut self, guard: &mut Guard, at: Instant, board: Board) -> Result<(), Self::Error>;

    fn all_off(&mut self) -> Result<(), Self::Error>;

    /// As [`Actuators::confirmed`].
    fn confirmed(&self, asked: Instant) -> Instant;
}

/// A driver behind the guard.
pub(super) struct Guards<'a, A>(pub(super) &'a mut A);

impl<A: Actuators> Outlet for Guards<'_, A> {
    type Error = A::Error;
    const STOPS: bool = true;

    fn send(
        &mut self,
        guard: &mut Guard,
        at: Instant,
        board: Board,
        stimuli: &[Stimulus],
        ledger: impl FnMut(Entry),
    ) -> Result<(), A::Error> {
        let update = guard.admit(at, board, stimuli, ledger);
        if update.changes() {
            self.0.apply(&update)?;
            guard.confirm(&update, self.0.confirmed(at));
        }
        Ok(())
    }

    fn expire(&mut self, guard: &mut Guard, at: Instant, board: Board) -> Result<(), A::Error> {
        let update = guard.expire(at, board);
        if update.changes() {
            self.0.apply(&update)?;
            guard.confirm(&update, self.0.confirmed(at));
        }
        Ok(())
    }

    fn all_off(&mut self) -> Result<(), A::Error> {
        self.0.all_off()
    }

    fn confirmed(&self, asked: Instant) -> Instant {
        self.0.confirmed(asked)
    }
}

/// Emulated registers beside the guard.
pub(super) struct Observes<'a, W>(pub(super) &'a mut W);

impl<W: ObservedRegisters> Outlet for Observes<'_, W> {
    type Error = W::Error;
    const STOPS: bool = false;

    fn send(
        &mut self,
        guard: &mut Guard,
        at: Instant,
        board: Board,
        stimuli: &[Stimulus],
        ledger: impl FnMut(Entry),
    ) -> Result<(), W::Error> {
        if let Some(update) = guard.observe(at, board, stimuli, ledger) {
            self.0.write(&update)?;
            guard.confirm_observed(&update);
        }
        Ok(())
    }

    fn expire(&mut self, guard: &mut Guard, at: Instant, board: Board) -> Result<(), W::Error> {
        let update = guard.observe_expiry(at, board);
        update.map_or(Ok(()), |update| self.0.write(&update))
    }

    fn all_off(&mut self) -> Result<(), W::Error> {
        self.0.all_off()
    }

    fn confirmed(&self, asked: Instant) -> Instant {
        asked
    }
}

#[cfg(test)]
#[path = "outlet_tests.rs"]
mod tests;
