//! The traits the projection talks to. Real buses and emulators implement the same two.

use embedded_can::Error as CanError;

use crate::guard::Guarded;
use crate::units::Instant;
use crate::wire::can::CanFrame;

/// A frame as it came off a sensor bus.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Received {
    /// When it was received: the end of the frame on the wire.
    pub at: Instant,
    /// Which of the bench's sensor buses it came from, zero-based.
    pub bus: u8,
    /// The frame.
    pub frame: CanFrame,
}

/// The CAN segment(s) the skin hangs on.
pub trait SensorBus {
    /// What can go wrong, in embedded-can's terms.
    type Error: CanError;

    /// The oldest frame not yet taken, or `None` when there is none. Never waits.
    fn receive(&mut self) -> Result<Option<Received>, Self::Error>;

    /// Queues a frame on `bus`.
    fn transmit(&mut self, bus: u8, frame: &CanFrame) -> Result<(), Self::Error>;
}

/// The driver unit that feeds the wires: accepts only what the guard has passed.
pub trait Actuators {
    /// What can go wrong on the actuator bus.
    type Error: core::fmt::Debug;

    /// Puts a guarded update on the outputs of one board, all its channels together.
    fn apply(&mut self, update: &Guarded) -> Result<(), Self::Error>;

    /// Switches every output of every board off. Needs no guard.
    fn all_off(&mut self) -> Result<(), Self::Error>;
}
