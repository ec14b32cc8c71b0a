//! The wire between the nodes: who sends when, how long it takes, what goes wrong.
//!
//! Nothing happens unless [`CanSegment::advance`] is called. Frames offered at one instant compete: a
//! start of frame at `t` is decided when time passes *beyond* `t`, so that the order of calls at `t`
//! does not matter.

mod confinement;

use std::collections::VecDeque;

use palpate_core::codec::can::CanFrame;

use super::bits;
use super::node::{Confinement, Filter, Node, NodeConfig, NodeId, SendError};
use crate::time::Nanos;

/// Bits of an error frame: active flag, the others' echo of it, delimiter (an upper bound of 20).
const ERROR_FRAME: u32 = 20;
/// Bits of an error frame from an error-passive node: no other node echoes its recessive bits.
const PASSIVE_ERROR_FRAME: u32 = 14;
/// Bits an error-passive node waits after its own frame beyond the intermission.
const SUSPEND: u32 = 8;
/// No frame waits.
const NO_HEAD: u16 = u16::MAX;

/// The five error classes of CAN (ISO 11898-1, 10.11).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum ErrorClass {
    /// A sender read another level than it sent.
    Bit,
    /// Six equal bits in the stuffed part.
    Stuff,
    /// The checksum does not match.
    Crc,
    /// A fixed bit has the wrong level.
    Form,
    /// No other node acknowledged.
    Ack,
}

/// Traffic and errors on a segment since its start.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Statistics {
    /// Frames completed.
    pub frames: u64,
    /// Bits of those frames, stuffing and intermission included.
    pub bits: u64,
    /// Bits lost to destroyed frames and error frames.
    pub error_bits: u64,
    /// Errors by class in the order of [`ErrorClass`].
    pub errors: [u64; 5],
}

#[derive(Clone, Debug)]
pub(super) struct Transmission {
    pub(super) sender: usize,
    pub(super) frame: CanFrame,
    /// Nodes that sent the same identifier at the same moment, with their frames.
    pub(super) rivals: Vec<(usize, CanFrame)>,
    error: Option<ErrorClass>,
    end: Nanos,
    free_at: Nanos,
}

/// One CAN bus with its nodes.
#[derive(Clone, Debug)]
pub struct CanSegment {
    bitrate: u32,
    /// Length of a bit, ns, where it is a whole number of them: a division a frame less.
    whole_bit_ns: Option<u64>,
    pub(super) now: Nanos,
    pub(super) nodes: Vec<Node>,
    /// Identifier each node offers, beside the nodes so that arbitration reads one cache line.
    heads: Vec<u16>,
    /// No node that may send has to wait for longer than this.
    held_until: Nanos,
    pub(super) busy: Option<Transmission>,
    free_at: Nanos,
    contend_at: Nanos,
    pub(super) restart_at: Nanos,
    injected: VecDeque<ErrorClass>,
    pub(super) statistics: Statistics,
}

impl CanSegment {
    /// An idle bus at `bitrate` bit/s (at least 1).
    pub fn new(bitrate: u32) -> Self {
        let bitrate = bitrate.max(1);
        let divides = 1_000_000_000 % bitrate == 0;
        Self {
            bitrate,
            whole_bit_ns: divides.then_some(u64::from(1_000_000_000 / bitrate)),
            now: Nanos::ZERO,
            nodes: Vec::new(),
            heads: Vec::new(),
            held_until: Nanos::ZERO,
            busy: None,
            free_at: Nanos::ZERO,
            contend_at: Nanos::MAX,
            restart_at: Nanos::MAX,
            injected: VecDeque::new(),
            statistics: Statistics::default(),
        }
    }

    /// Connects a controller.
    pub fn attach(&mut self, config: NodeConfig) -> NodeId {
        self.nodes.push(Node::new(config));
        self.heads.push(NO_HEAD);
        NodeId(self.nodes.len() - 1)
    }

    /// The moment up to which everything has happened.
    pub const fn now(&self) -> Nanos {
        self.now
    }

    /// Traffic and errors so far.
    pub const fn statistics(&self) -> &Statistics {
        &self.statistics
    }

    /// Share of the time from the start until now in which the bus was not idle, 0 to 1.
    pub fn load(&self) -> f64 {
        let bits = self.statistics.bits + self.statistics.error_bits;
        bits as f64 / (self.now.as_secs_f64() * f64::from(self.bitrate)).max(1.0)
    }

    /// Offers a frame for transmission at the present moment.
    pub fn send(&mut self, node: NodeId, frame: &CanFrame) -> Result<(), SendError> {
        self.put(node, frame, false)
    }

    /// Sends a frame as [`Self::send`] does, in the place of a waiting frame with the same identifier.
    pub fn replace(&mut self, node: NodeId, frame: &CanFrame) -> Result<(), SendError> {
        self.put(node, frame, true)
    }

    fn put(&mut self, NodeId(n): NodeId, frame: &CanFrame, replace: bool) -> Result<(), SendError> {
        let node = self.nodes.get_mut(n).ok_or(SendError::NoNode)?;
        node.put(frame, replace)?;
        let ready = self.now.max(self.free_at).max(node.not_before);
        self.refresh(n);
        if self.busy.is_none() {
            self.contend_at = self.contend_at.min(ready);
        }
        Ok(())
    }

    /// The oldest frame a node received and has not read, with the end of the frame on the wire.
    pub fn receive(&mut self, NodeId(n): NodeId) -> Option<(Nanos, CanFrame)> {
        self.nodes.get_mut(n)?.receive.pop_front()
    }

    /// Reception of the frame that [`Self::receive`] would return.
    pub(crate) fn received_at(&self, NodeId(n): NodeId) -> Option<Nanos> {
        Some(self.nodes.get(n)?.receive.front()?.0)
    }

    /// Frames a node lost because it did not read in time.
    pub fn overflows(&self, NodeId(n): NodeId) -> u64 {
        self.nodes.get(n).map_or(0, |node| node.overflow)
    }

    /// Frames of a node that are waiting or on the wire.
    pub fn pending(&self, NodeId(n): NodeId) -> usize {
        let on_wire = self
            .busy
            .as_ref()
            .is_some_and(|t| t.sender == n || t.rivals.iter().any(|&(rival, _)| rival == n));
        self.nodes.get(n).map_or(0, |node| node.transmit.len()) + usize::from(on_wire)
    }

    /// Transmit and receive error counters and the state they put a node in.
    pub fn confinement(&self, NodeId(n): NodeId) -> Option<(Confinement, u16, u16)> {
        let node = self.nodes.get(n)?;
        Some((node.confinement(), node.tec, node.rec))
    }

    /// Destroys the next frame on the wire by an error of this class; several queue up.
    pub fn inject(&mut self, error: ErrorClass) {
        self.injected.push_back(error);
    }

    /// Drops the frames that a node wanted to send (its reset, or its power is cut).
    pub fn clear(&mut self, NodeId(n): NodeId) {
        if let Some(node) = self.nodes.get_mut(n) {
            node.transmit.clear();
            self.refresh(n);
        }
    }

    /// The next moment at which something can happen; [`Nanos::MAX`] if nothing will.
    pub fn next_event(&self) -> Nanos {
        let wire = match &self.busy {
            Some(t) => t.end,
            None => self.contend_at + Nanos(1),
        };
        wire.min(self.restart_at)
    }

    /// Lets time pass until `to`, or until a node with [`Filter::Wake`] received a frame: then the
    /// node is returned and [`Self::now`] is that moment.
    pub fn advance(&mut self, to: Nanos) -> Option<NodeId> {
        loop {
            let (wire_at, wire_due) = match &self.busy {
                Some(t) => (t.end, t.end <= to),
                None => (self.contend_at, self.contend_at < to),
            };
            if self.restart_at <= to && self.restart_at <= wire_at && self.restart_at != Nanos::MAX
            {
                self.bring_back();
            } else if !wire_due {
                self.now = self.now.max(to);
                return None;
            } else if let Some(transmission) = self.busy.take() {
                let woken = self.complete(transmission);
                if woken.is_some() {
                    return woken;
                }
            } else {
                self.arbitrate();
            }
        }
    }

    pub(super) fn span(&self, bits: u32) -> Nanos {
        let bits = u64::from(bits);
        Nanos(match self.whole_bit_ns {
            Some(bit) => bits * bit,
            None => bits * 1_000_000_000 / u64::from(self.bitrate),
        })
    }

    pub(super) fn refresh(&mut self, n: usize) {
        let node = &self.nodes[n];
        self.heads[n] = match node.transmit.front() {
            Some(frame) if !node.bus_off => frame.id(),
            _ => NO_HEAD,
        };
        if self.heads[n] != NO_HEAD {
            self.held_until = self.held_until.max(node.not_before);
        }
    }

    /// Finds the time of the next start of frame, `free_at` at the earliest.
    pub(super) fn recontend(&mut self) {
        let from = self.free_at;
        if self.held_until <= from {
            let waits = self.heads.iter().any(|head| *head != NO_HEAD);
            self.contend_at = if waits { from } else { Nanos::MAX };
            return;
        }
        let waiting = self.heads.iter().zip(&self.nodes);
        self.contend_at = waiting
            .filter(|&(&head, _)| head != NO_HEAD)
            .map(|(_, node)| node.not_before.max(from))
            .min()
            .unwrap_or(Nanos::MAX);
    }

    /// The frame that a node offers, to be sent.
    fn take(&mut self, n: usize) -> Option<CanFrame> {
        let frame = self.nodes[n].transmit.pop_front();
        self.refresh(n);
        frame
    }

    /// Starts the frame with the lowest identifier.
    fn arbitrate(&mut self) {
        let start = self.contend_at;
        self.now = self.now.max(start);
        self.contend_at = Nanos::MAX;
        // One look at what every node offers: the lowest identifier, who has it first, who else.
        let (mut lowest, mut first, mut shared) = (NO_HEAD, 0, false);
        let held = self.held_until > start;
        for (n, &head) in self.heads.iter().enumerate() {
            if head > lowest || head == NO_HEAD || held && self.nodes[n].not_before > start {
                continue;
            }
            shared = head == lowest;
            if !shared {
                (lowest, first) = (head, n);
            }
        }
        if lowest == NO_HEAD {
            return;
        }
        let Some(mut frame) = self.take(first) else {
            return;
        };
        let (mut sender, mut rivals) = (first, Vec::new());
        for n in first + 1..if shared { self.nodes.len() } else { 0 } {
            if self.heads[n] == lowest && self.nodes[n].not_before <= start {
                rivals.extend(self.take(n).map(|frame| (n, frame)));
            }
        }
        // Of frames with one identifier the one with the first dominant bit survives; where the
        // loser notices, it destroys the frame if its flag is an active one.
        let mut collision = None;
        for rival in &mut rivals {
            if bits::stuffed(&rival.1).lt(bits::stuffed(&frame)) {
                std::mem::swap(&mut rival.0, &mut sender);
                std::mem::swap(&mut rival.1, &mut frame);
            }
        }
        for (n, other) in &rivals {
            if let Some(at) = bits::first_difference(&frame, other)
                && self.nodes[*n].confinement() == Confinement::Active
            {
                collision = Some(collision.map_or(at, |first: u32| first.min(at)));
            }
        }
        let whole = bits::length(&frame);
        let alone = !(0..self.nodes.len()).any(|n| {
            n != sender && !self.nodes[n].bus_off && !rivals.iter().any(|&(rival, _)| rival == n)
        });
        let (error, at) = match collision {
            Some(at) => (Some(ErrorClass::Bit), at + 1),
            None => match self
                .injected
                .pop_front()
                .or(alone.then_some(ErrorClass::Ack))
            {
                Some(error @ (ErrorClass::Bit | ErrorClass::Stuff)) => (Some(error), whole / 2),
                Some(ErrorClass::Crc) => (Some(ErrorClass::Crc), whole - 7),
                Some(ErrorClass::Form) => (Some(ErrorClass::Form), whole - 3),
                Some(ErrorClass::Ack) => (Some(ErrorClass::Ack), whole - 8),
                None => (None, whole),
            },
        };
        let length = match error {
            None => at,
            Some(_) if self.nodes[sender].confinement() == Confinement::Active => at + ERROR_FRAME,
            Some(_) => at + PASSIVE_ERROR_FRAME,
        };
        let total = length + bits::INTERMISSION;
        match error {
            None => self.statistics.bits += u64::from(total),
            Some(_) => self.statistics.error_bits += u64::from(total),
        }
        self.busy = Some(Transmission {
            sender,
            frame,
            rivals,
            error,
            end: start + self.span(length),
            free_at: start + self.span(total),
        });
    }

    /// Ends the frame on the wire; returns the woken node.
    fn complete(&mut self, t: Transmission) -> Option<NodeId> {
        self.now = t.end;
        self.free_at = t.free_at;
        let mut woken = None;
        let sends = |n| t.sender == n || t.rivals.iter().any(|&(rival, _)| rival == n);
        if let Some(error) = t.error {
            self.fail(&t, error);
        } else {
            self.statistics.frames += 1;
            self.nodes[t.sender].tec = self.nodes[t.sender].tec.saturating_sub(1);
            let (unrivalled, id) = (t.rivals.is_empty(), t.frame.id());
            for (n, node) in self.nodes.iter_mut().enumerate() {
                if node.bus_off || n == t.sender || !unrivalled && sends(n) {
                    continue;
                }
                if node.rec != 0 {
                    node.rec = if node.rec > 127 { 120 } else { node.rec - 1 };
                }
                if node.config.filter.takes(id) {
                    node.deliver(t.end, &t.frame);
                    if matches!(node.config.filter, Filter::Wake(_)) {
                        woken = Some(NodeId(n));
                    }
                }
            }
            // A rival that sent the very same bits is done too; another one lost its frame.
            for (n, frame) in &t.rivals {
                if *frame == t.frame {
                    self.nodes[*n].tec = self.nodes[*n].tec.saturating_sub(1);
                } else {
                    self.statistics.errors[ErrorClass::Bit as usize] += 1;
                    self.penalise(*n, frame);
                }
            }
        }
        if self.nodes[t.sender].confinement() == Confinement::Passive {
            let suspend = self.free_at + self.span(SUSPEND);
            self.nodes[t.sender].not_before = suspend;
            self.held_until = self.held_until.max(suspend);
        }
        self.recontend();
        woken
    }
}
