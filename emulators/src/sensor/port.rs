//! The host's controller on one bus behind `embedded_can`, non-blocking and blocking: what a driver of one's own holds.

use embedded_can::{blocking, nb as polled};
use palpate_core::bus::CanBus;
use palpate_core::codec::can::CanFrame;

use crate::sensor::rig::{Handle, HostError, SkinBus};
use crate::time::Nanos;

/// Time for which the blocking face waits.
const PATIENCE: Nanos = Nanos::from_micros(1_000_000);

/// One bus of a rig as a CAN driver sees it.
///
/// The non-blocking face never lets time pass: the owner of the bench does, with [`Handle::advance`]. The blocking face
/// lets virtual time pass on all buses until a frame comes, or a place in the queue is free, for a second at most.
///
/// ```
/// use embedded_can::{Frame, Id, StandardId, blocking::Can};
/// use palpate_core::codec::can::CanFrame;
/// use palpate_emulators::sensor::board::BoardConfig;
/// use palpate_emulators::sensor::port::HostPort;
/// use palpate_emulators::sensor::rig::{Handle, SkinBus};
/// use palpate_emulators::sensor::{EmulatedModule, ModuleConfig};
///
/// let mut bus = SkinBus::new(1_000_000); // bit/s
/// bus.add_board(BoardConfig::default(), vec![EmulatedModule::new(ModuleConfig::default())])?;
/// let mut port = HostPort::new(Handle::new(vec![bus]), 0);
///
/// let start = CanFrame::new(0x200, &[7, 0]).ok_or("too long")?; // board 0 begins to send its taxels
/// port.transmit(&start)?;
/// let frame = port.receive()?; // 0.2 ms later
/// assert_eq!(Frame::id(&frame), Id::Standard(StandardId::ZERO)); // taxel 0 of board 0
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone)]
pub struct HostPort {
    rig: Handle,
    bus: u8,
}

impl HostPort {
    /// The host's controller on bus number `bus` of a rig. Where there is no such bus, all calls say so.
    pub const fn new(rig: Handle, bus: u8) -> Self {
        Self { rig, bus }
    }

    fn now(&self) -> Result<Nanos, HostError> {
        let bus = usize::from(self.bus);
        let now = |bus: &SkinBus| bus.segment().now();
        self.rig
            .with(|buses| buses.get(bus).map(now))
            .ok_or(HostError::NoBus)
    }

    /// Tries again at every event until it works, or until the port's patience is over.
    fn wait<T>(
        &mut self,
        mut attempt: impl FnMut(&mut Self) -> nb::Result<T, HostError>,
    ) -> Result<T, HostError> {
        let last = self.now()? + PATIENCE;
        loop {
            match attempt(self) {
                Ok(done) => return Ok(done),
                Err(nb::Error::Other(error)) => return Err(error),
                Err(nb::Error::WouldBlock) => {}
            }
            let now = self.now()?;
            if now >= last {
                return Err(HostError::TimedOut);
            }
            let next = self.rig.next_event().max(now + Nanos(1));
            self.rig.advance(next.min(last));
        }
    }
}

impl polled::Can for HostPort {
    type Frame = CanFrame;
    type Error = HostError;

    /// Sends a frame. It pushes nothing out of the queue to make room.
    fn transmit(&mut self, frame: &CanFrame) -> nb::Result<Option<CanFrame>, HostError> {
        match self.rig.transmit(self.bus, frame) {
            Ok(()) => Ok(None),
            Err(HostError::QueueFull) => Err(nb::Error::WouldBlock),
            Err(error) => Err(nb::Error::Other(error)),
        }
    }

    fn receive(&mut self) -> nb::Result<CanFrame, HostError> {
        let received = self.rig.with(|buses| {
            let bus = buses.get_mut(usize::from(self.bus));
            let bus = bus.ok_or(HostError::NoBus)?;
            let host = bus.host();
            Ok::<_, HostError>(bus.segment_mut().receive(host))
        });
        received
            .map_err(nb::Error::Other)?
            .map(|(_, frame)| frame)
            .ok_or(nb::Error::WouldBlock)
    }
}

impl blocking::Can for HostPort {
    type Frame = CanFrame;
    type Error = HostError;

    fn transmit(&mut self, frame: &CanFrame) -> Result<(), HostError> {
        self.wait(|port| polled::Can::transmit(port, frame))
            .map(|_| ())
    }

    fn receive(&mut self) -> Result<CanFrame, HostError> {
        self.wait(polled::Can::receive)
    }
}

#[cfg(test)]
#[path = "port_tests.rs"]
mod tests;
