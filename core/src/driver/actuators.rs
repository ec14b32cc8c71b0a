//! What every driver is to the loop.

use crate::guard::{Guarded, Observed};

/// The driver unit that feeds the wires: accepts only what the guard has passed.
pub trait Actuators {
    /// What can go wrong on the actuator bus.
    type Error: core::fmt::Debug;

    /// Puts a guarded update on the outputs of one board, all its channels together.
    fn apply(&mut self, update: &Guarded) -> Result<(), Self::Error>;

    /// Switches every output of every board off. Needs no guard.
    fn all_off(&mut self) -> Result<(), Self::Error>;
}

/// Emulated registers, in a run that the guard only observes. Nothing that drives hardware implements it; the writer
/// of the emulators does.
pub trait ObservedRegisters {
    /// What can go wrong on the emulated bus.
    type Error: core::fmt::Debug;

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
