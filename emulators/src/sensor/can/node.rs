//! One controller on the segment: its transmit store, its receive queue, its error counters.

use std::collections::VecDeque;

use palpate_core::codec::can::CanFrame;

use crate::time::Nanos;

/// A node's number on its segment.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct NodeId(pub(super) usize);

/// Order in which a controller offers its waiting frames to arbitration.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Order {
    /// The oldest (a queue, as SocketCAN has).
    #[default]
    Fifo,
    /// The lowest identifier (mailboxes, as microcontrollers have).
    Priority,
}

/// Frames that a node takes in.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Filter {
    /// Every frame.
    #[default]
    All,
    /// These two identifiers; receiving one ends [`super::CanSegment::advance`] early, so that the
    /// owner can react at that very moment.
    Wake([u16; 2]),
}

impl Filter {
    pub(super) const fn takes(self, id: u16) -> bool {
        match self {
            Self::All => true,
            Self::Wake([a, b]) => id == a || id == b,
        }
    }
}

/// Settings of a node.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct NodeConfig {
    /// Order in which waiting frames go.
    pub order: Order,
    /// Frames that may wait for transmission.
    pub transmit_limit: usize,
    /// Frames that may wait to be read; a frame that comes beyond these is lost and counted.
    pub receive_limit: usize,
    /// Filter of received frames.
    pub filter: Filter,
    /// Time from bus-off to the restart; `None`: it stays off until [`super::CanSegment::restart`]
    /// (SocketCAN's `restart-ms 0`).
    pub restart_after: Option<Nanos>,
}

impl Default for NodeConfig {
    /// A host's interface: everything received, SocketCAN's queue of ten frames, no automatic restart.
    fn default() -> Self {
        Self {
            order: Order::Fifo,
            transmit_limit: 10,
            receive_limit: 4096,
            filter: Filter::All,
            restart_after: None,
        }
    }
}

/// Reasons for which a frame was not taken for transmission.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum SendError {
    /// The transmit store is full (`ENOBUFS`): trying again later makes sense.
    #[error("the transmit store is full; try again later")]
    Full,
    /// The controller is bus-off (`ENETDOWN`): a retry makes sense after a restart.
    #[error("the controller is bus-off; restart it first")]
    BusOff,
    /// No such node on this segment.
    #[error("no such node on this segment")]
    NoNode,
}

/// Fault confinement state (ISO 11898-1, 12.1.4).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Confinement {
    /// Takes full part.
    #[default]
    Active,
    /// A counter is over 127: sends recessive error flags, waits 8 bits after its own frames.
    Passive,
    /// The transmit counter is over 255: off the bus.
    BusOff,
}

#[derive(Clone, Debug)]
pub(super) struct Node {
    pub(super) config: NodeConfig,
    pub(super) transmit: VecDeque<CanFrame>,
    pub(super) receive: VecDeque<(Nanos, CanFrame)>,
    pub(super) overflow: u64,
    /// Transmit and receive error counters.
    pub(super) tec: u16,
    pub(super) rec: u16,
    pub(super) bus_off: bool,
    /// No start of frame before this: suspend transmission of an error-passive node, bus-off.
    pub(super) not_before: Nanos,
}

impl Node {
    pub(super) fn new(config: NodeConfig) -> Self {
        Self {
            config,
            transmit: VecDeque::new(),
            receive: VecDeque::new(),
            overflow: 0,
            tec: 0,
            rec: 0,
            bus_off: false,
            not_before: Nanos::ZERO,
        }
    }

    pub(super) const fn confinement(&self) -> Confinement {
        if self.bus_off {
            Confinement::BusOff
        } else if self.tec > 127 || self.rec > 127 {
            Confinement::Passive
        } else {
            Confinement::Active
        }
    }

    /// Position at which a frame waits (or already waits, with the same identifier, when `replace`).
    pub(super) fn put(&mut self, frame: &CanFrame, replace: bool) -> Result<(), SendError> {
        if self.bus_off {
            return Err(SendError::BusOff);
        }
        let same = |waiting: &&mut CanFrame| waiting.id() == frame.id();
        if replace && let Some(slot) = self.transmit.iter_mut().find(same) {
            *slot = *frame;
            return Ok(());
        }
        if self.transmit.len() >= self.config.transmit_limit {
            return Err(SendError::Full);
        }
        match self.config.order {
            Order::Fifo => self.transmit.push_back(*frame),
            Order::Priority => {
                let at = self.transmit.partition_point(|w| w.id() <= frame.id());
                self.transmit.insert(at, *frame);
            }
        }
        Ok(())
    }

    pub(super) fn deliver(&mut self, at: Nanos, frame: &CanFrame) {
        if self.receive.len() < self.config.receive_limit {
            self.receive.push_back((at, *frame));
        } else {
            self.overflow += 1;
        }
    }
}
