//! The sensor side of a bench: segments with their boards, and the host's interface to them.
//!
//! Only [`Handle::advance`] makes time pass. The projector holds a clone of the handle as its
//! [`CanBus`]; the owner of the bench holds another and decides how far virtual time goes.

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use embedded_can::{Error as CanError, ErrorKind};
use palpate_core::bus::{CanBus, Received};
use palpate_core::codec::can::CanFrame;
use palpate_core::units::Instant;

use crate::sensor::EmulatedModule;
use crate::sensor::board::{BoardConfig, BoardError, SensorBoard};
use crate::sensor::can::{CanSegment, NodeConfig, NodeId, SendError};
use crate::time::Nanos;

/// One segment with the boards on it and the host's controller.
pub struct SkinBus {
    segment: CanSegment,
    host: NodeId,
    boards: Vec<SensorBoard>,
    /// The earliest of the boards' next events.
    boards_next: Nanos,
}

impl SkinBus {
    /// A bus at `bitrate` bit/s with a host whose queue takes a burst of commands.
    pub fn new(bitrate: u32) -> Self {
        Self::with_host(bitrate, NodeConfig::default())
    }

    /// A bus with a host's interface of one's own: queue limits, restart behaviour.
    pub fn with_host(bitrate: u32, host: NodeConfig) -> Self {
        let mut segment = CanSegment::new(bitrate);
        let host = segment.attach(host);
        Self {
            segment,
            host,
            boards: Vec::new(),
            boards_next: Nanos::MAX,
        }
    }

    /// Connects a board with its modules.
    pub fn add_board(
        &mut self,
        config: BoardConfig,
        modules: Vec<EmulatedModule>,
    ) -> Result<(), BoardError> {
        let board = SensorBoard::new(config, modules, &mut self.segment)?;
        self.boards_next = self.boards_next.min(board.next_event());
        self.boards.push(board);
        Ok(())
    }

    /// The wire: load, statistics, errors, injected faults.
    pub const fn segment(&self) -> &CanSegment {
        &self.segment
    }

    /// The wire, to disturb it.
    pub const fn segment_mut(&mut self) -> &mut CanSegment {
        &mut self.segment
    }

    /// The host's controller on the segment.
    pub const fn host(&self) -> NodeId {
        self.host
    }

    /// The boards in the order in which they were added.
    pub fn boards(&self) -> &[SensorBoard] {
        &self.boards
    }

    /// Does something to a board at the present moment: power, clock, number.
    pub fn disturb(&mut self, n: usize, work: impl FnOnce(&mut SensorBoard, &mut CanSegment)) {
        if let Some(board) = self.boards.get_mut(n) {
            work(board, &mut self.segment);
        }
        let next = self.boards.iter().map(SensorBoard::next_event).min();
        self.boards_next = next.unwrap_or(Nanos::MAX);
    }

    /// The next moment at which something can happen here.
    pub fn next_event(&self) -> Nanos {
        self.segment.next_event().min(self.boards_next)
    }

    /// Reception of the oldest frame that the host has yet to read; [`Nanos::MAX`] where there is none.
    fn head(&self) -> Nanos {
        self.segment.received_at(self.host).unwrap_or(Nanos::MAX)
    }

    /// Lets time pass until `to`: every scan, frame and command in its order.
    pub fn advance(&mut self, to: Nanos) {
        loop {
            let step = self.boards_next.min(to);
            let woken = self.segment.advance(step).is_some();
            if woken {
                for board in &mut self.boards {
                    board.obey(&mut self.segment);
                }
            } else if self.boards_next > to {
                return;
            }
            let now = self.segment.now();
            let mut next = Nanos::MAX;
            for board in &mut self.boards {
                if board.next_event() <= now {
                    board.act(&mut self.segment);
                }
                next = next.min(board.next_event());
            }
            self.boards_next = next;
        }
    }
}

/// Errors of the host's interface, in embedded-can's terms.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum HostError {
    /// The transmit queue is full (`ENOBUFS`): try again later.
    #[error("transmit queue full, try again later")]
    QueueFull,
    /// The controller is bus-off: it needs a restart.
    #[error("controller is bus-off, restart it")]
    BusOff,
    /// The bench has no such bus.
    #[error("no such sensor bus")]
    NoBus,
    /// No frame or place in the queue came while a port waited.
    #[error("nothing came in the time that the port waits")]
    TimedOut,
}

impl CanError for HostError {
    fn kind(&self) -> ErrorKind {
        ErrorKind::Other
    }
}

/// The host's interface to all sensor buses of a bench; clones share the hardware.
#[derive(Clone)]
pub struct Handle {
    buses: Arc<Mutex<Vec<SkinBus>>>,
}

impl Handle {
    /// The interface to these buses, numbered from 0 in this order.
    pub fn new(buses: Vec<SkinBus>) -> Self {
        Self {
            buses: Arc::new(Mutex::new(buses)),
        }
    }

    /// Looks at or disturbs the hardware: load, boards, touches, injected faults. `f` must not use
    /// this handle or a clone of it: it would wait for itself.
    pub fn with<R>(&self, f: impl FnOnce(&mut Vec<SkinBus>) -> R) -> R {
        f(&mut self.lock())
    }

    /// The buses, for one question or one stretch of time.
    fn lock(&self) -> MutexGuard<'_, Vec<SkinBus>> {
        self.buses.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// The next moment at which something can happen on a bus. Stepping there is not needed:
    /// [`Self::advance`] takes any stretch, and frames carry their own times.
    pub fn next_event(&self) -> Nanos {
        let buses = self.lock();
        buses
            .iter()
            .map(SkinBus::next_event)
            .min()
            .unwrap_or(Nanos::MAX)
    }

    /// Lets time pass on all buses until `to`.
    pub fn advance(&self, to: Nanos) {
        for bus in self.lock().iter_mut() {
            bus.advance(to);
        }
    }
}

impl Handle {
    /// The oldest frame over all buses with the end of the frame on the wire; of two received at once the
    /// one from the lower bus.
    pub fn receive_at(&mut self) -> Option<(Nanos, Received)> {
        let mut buses = self.lock();
        let mut heads: Vec<Nanos> = buses.iter().map(SkinBus::head).collect();
        oldest(&mut buses, &mut heads)
    }

    /// Every frame that [`Self::receive_at`] would return, in its order. `take` must not use this handle or a clone of it:
    /// it would wait for itself.
    pub fn receive_all_at(&mut self, take: &mut impl FnMut(Nanos, &Received)) {
        let mut buses = self.lock();
        let mut heads: Vec<Nanos> = buses.iter().map(SkinBus::head).collect();
        while let Some((at, received)) = oldest(&mut buses, &mut heads) {
            take(at, &received);
        }
    }
}

/// The oldest frame that a host has yet to read, by the times of each bus's oldest.
fn oldest(buses: &mut [SkinBus], heads: &mut [Nanos]) -> Option<(Nanos, Received)> {
    let (mut first, mut n) = (Nanos::MAX, 0);
    for (bus, head) in heads.iter().enumerate() {
        if *head < first {
            (first, n) = (*head, bus);
        }
    }
    let bus = buses.get_mut(n)?;
    let (at, frame) = bus.segment.receive(bus.host)?;
    heads[n] = bus.head();
    let received = Received {
        at: Instant::from_micros(at.as_micros()),
        bus: n as u8,
        frame,
    };
    Some((at, received))
}

impl CanBus for Handle {
    type Error = HostError;

    fn receive(&mut self) -> Result<Option<Received>, HostError> {
        Ok(self.receive_at().map(|(_, received)| received))
    }

    fn transmit(&mut self, bus: u8, frame: &CanFrame) -> Result<(), HostError> {
        let mut buses = self.lock();
        let bus = buses.get_mut(usize::from(bus)).ok_or(HostError::NoBus)?;
        let sent = bus.segment.send(bus.host, frame);
        sent.map_err(|error| match error {
            SendError::Full => HostError::QueueFull,
            SendError::BusOff => HostError::BusOff,
            SendError::NoNode => HostError::NoBus,
        })
    }
}

#[cfg(test)]
mod tests;
