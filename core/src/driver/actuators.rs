//! What every driver is to the loop.

use crate::guard::Guarded;

/// The driver unit that feeds the wires: accepts only what the guard has passed.
pub trait Actuators {
    /// What can go wrong on the actuator bus.
    type Error: core::fmt::Debug;

    /// Puts a guarded update on the outputs of one board, all its channels together.
    fn apply(&mut self, update: &Guarded) -> Result<(), Self::Error>;

    /// Switches every output of every board off. Needs no guard.
    fn all_off(&mut self) -> Result<(), Self::Error>;
}
