//! The interface of every driver to the loop.

use alloc::vec::Vec;

use super::{DriverError, Traffic};
use crate::guard::Guarded;
use crate::units::{Board, Instant};

/// A driver of actuators of one kind, which takes updates of one type alone: [`Guarded`] for wires,
/// [`GuardedVibration`](crate::guard::GuardedVibration) for motors,
/// [`GuardedCurrent`](crate::peltier::GuardedCurrent) for a Peltier module. Only a guard makes these. Emulated registers
/// take [`Observed`](crate::guard::Observed); nothing that drives hardware does.
pub trait Actuators<U = Guarded> {
    /// Error of the actuator bus.
    type Error: core::error::Error;

    /// Puts a guarded update on the outputs: of wires those of one board, all its channels together. Where amplifiers are
    /// set, `Ok` says that every current of the update was set and has read back before any of its pulses.
    fn apply(&mut self, update: &U) -> Result<(), Self::Error>;

    /// Switches every output off. Needs no guard.
    fn all_off(&mut self) -> Result<(), Self::Error>;

    /// Time from which the last applied update, or switching off, is known to stand on the outputs. It is asked once
    /// the call has returned `Ok`. A driver without a clock returns `asked`, the time of the call.
    fn confirmed(&self, asked: Instant) -> Instant {
        asked
    }
}

/// Boards that can be started, read back and driven, by updates of one type.
pub trait Driver<U = Guarded>: Actuators<U, Error = DriverError> {
    /// Switches everything off and sets the boards up. Returns when the first update may come.
    ///
    /// # Errors
    /// [`DriverError`] of the first board that does not answer or does not read back.
    fn start(&mut self, now: Instant) -> Result<Instant, DriverError>;

    /// Confirms that every board still is as [`Self::start`] left it.
    ///
    /// # Errors
    /// [`DriverError`] of the first board that does not answer or does not read back.
    fn verify(&mut self) -> Result<(), DriverError>;

    /// Transfers made again after a transient error.
    fn retries(&self) -> u64;

    /// Writes and channels that updates took on all buses so far.
    fn traffic(&self) -> Traffic;

    /// Every board, in the order of their numbers.
    fn boards(&self) -> Vec<Board>;
}
