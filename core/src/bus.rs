//! The bus that carries a skin's frames, as the projection sees it. Real interfaces and emulators implement it alike.

use embedded_can::Error as CanError;

use crate::codec::can::CanFrame;
use crate::units::Instant;

/// A frame as it came off a bus.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Received {
    /// Reception time: the end of the frame on the bus.
    pub at: Instant,
    /// Index of the bus that carried it among the bench's buses, zero-based.
    pub bus: u8,
    /// The frame.
    pub frame: CanFrame,
}

/// One or several CAN segments.
pub trait CanBus {
    /// Error of the bus, in embedded-can's terms and in words.
    type Error: CanError + core::error::Error;

    /// The oldest frame not yet taken, or `None` when there is none. Never waits.
    fn receive(&mut self) -> Result<Option<Received>, Self::Error>;

    /// Takes every frame that has come, the oldest first. A bus that has them at hand saves a call per frame.
    ///
    /// # Errors
    /// The first error of the bus; the frames before it have been taken.
    fn receive_all(&mut self, take: &mut impl FnMut(&Received)) -> Result<(), Self::Error>
    where
        Self: Sized,
    {
        while let Some(received) = self.receive()? {
            take(&received);
        }
        Ok(())
    }

    /// Queues a frame on `bus`.
    fn transmit(&mut self, bus: u8, frame: &CanFrame) -> Result<(), Self::Error>;
}

impl<B: CanBus + ?Sized> CanBus for &mut B {
    type Error = B::Error;

    fn receive(&mut self) -> Result<Option<Received>, B::Error> {
        (**self).receive()
    }

    fn transmit(&mut self, bus: u8, frame: &CanFrame) -> Result<(), B::Error> {
        (**self).transmit(bus, frame)
    }
}
