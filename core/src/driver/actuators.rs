//! What every driver is to the loop.

use crate::guard::{Guarded, Observed};
use crate::units::Instant;

/// What feeds actuators of one kind: accepts only what their guard has passed. Wires take [`Guarded`], a Peltier module
/// [`GuardedCurrent`](crate::peltier::GuardedCurrent).
pub trait Actuators<U = Guarded> {
    /// What can go wrong on the actuator bus.
    type Error: core::error::Error;

    /// Puts a guarded update on the outputs: of wires those of one board, all its channels together. Where amplifiers are
    /// set, `Ok` says that every current of the update was set and has read back before any of its pulses.
    fn apply(&mut self, update: &U) -> Result<(), Self::Error>;

    /// Switches every output off. Needs no guard.
    fn all_off(&mut self) -> Result<(), Self::Error>;

    /// When what was just applied, or switched off, is known to stand on the outputs: asked once the call has returned
    /// `Ok`. Without a clock that is when it was `asked` for.
    fn confirmed(&self, asked: Instant) -> Instant {
        asked
    }
}

/// Emulated registers, in a run that the guard only observes. Nothing that drives hardware implements it; the writer
/// of the emulators does.
pub trait ObservedRegisters {
    /// What can go wrong on the emulated bus.
    type Error: core::error::Error;

    /// Puts what the guard saw on the outputs of one board, all its channels together.
    ///
    /// # Errors
    /// The bus's.
    fn write(&mut self, update: &Observed) -> Result<(), Self::Error>;

    /// Switches every output of every board off.
    ///
    /// # Errors
    /// The bus's.
    fn all_off(&mut self) -> Result<(), Self::Error>;
}
