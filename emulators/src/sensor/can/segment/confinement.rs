//! Fault confinement: what errors do to the counters, and the way to bus-off and back.

use palpate_core::codec::can::CanFrame;

use super::{CanSegment, ErrorClass, Transmission};
use crate::sensor::can::node::{Confinement, NodeId, Order};
use crate::time::Nanos;

/// Recessive bits before a node comes back from bus-off (128 times 11).
const RECOVERY: u32 = 128 * 11;

impl CanSegment {
    /// Restarts a node from bus-off by hand; it takes part again after 128 times 11 bits.
    pub fn restart(&mut self, NodeId(n): NodeId) {
        let back = self.now + self.span(RECOVERY);
        if let Some(node) = self.nodes.get_mut(n)
            && node.bus_off
        {
            node.not_before = back;
            self.restart_at = self.restart_at.min(back);
        }
    }

    /// Lets nodes whose recovery is over take part again.
    pub(super) fn bring_back(&mut self) {
        self.now = self.now.max(self.restart_at);
        self.restart_at = Nanos::MAX;
        for n in 0..self.nodes.len() {
            let node = &mut self.nodes[n];
            if node.bus_off && node.not_before <= self.now {
                (node.bus_off, node.tec, node.rec) = (false, 0, 0);
                self.refresh(n);
            } else if node.bus_off && node.not_before != Nanos::MAX {
                self.restart_at = self.restart_at.min(node.not_before);
            }
        }
        if self.busy.is_none() {
            self.recontend();
        }
    }

    /// Counts a destroyed frame against everyone.
    pub(super) fn fail(&mut self, t: &Transmission, error: ErrorClass) {
        self.statistics.errors[error as usize] += 1;
        // An error-passive sender without an acknowledgement stays where it is: it may be alone.
        let alone =
            error == ErrorClass::Ack && self.nodes[t.sender].confinement() == Confinement::Passive;
        if alone {
            self.requeue(t.sender, &t.frame);
        } else {
            self.penalise(t.sender, &t.frame);
        }
        for (n, frame) in &t.rivals {
            self.penalise(*n, frame);
        }
        for n in 0..self.nodes.len() {
            let sends = n == t.sender || t.rivals.iter().any(|&(rival, _)| rival == n);
            if !sends && error != ErrorClass::Ack {
                self.nodes[n].rec = (self.nodes[n].rec + 1).min(255);
            }
        }
    }

    /// Counts a transmit error; the frame waits again unless the node goes bus-off.
    pub(super) fn penalise(&mut self, n: usize, frame: &CanFrame) {
        let node = &mut self.nodes[n];
        node.tec += 8;
        if node.tec <= 255 {
            self.requeue(n, frame);
            return;
        }
        self.cut_off(n);
    }

    /// Drives a node off the bus, as 32 failed transmissions in a row would.
    pub fn force_bus_off(&mut self, NodeId(n): NodeId) {
        if n < self.nodes.len() && !self.nodes[n].bus_off {
            self.nodes[n].tec = 256;
            self.cut_off(n);
        }
    }

    fn cut_off(&mut self, n: usize) {
        let recovery = self.span(RECOVERY);
        let node = &mut self.nodes[n];
        node.bus_off = true;
        node.transmit.clear();
        node.not_before = match node.config.restart_after {
            Some(wait) => self.now + wait + recovery,
            None => Nanos::MAX,
        };
        self.restart_at = self.restart_at.min(node.not_before);
        self.refresh(n);
    }

    /// Puts a frame back in front, unless a newer one with its identifier replaced it meanwhile.
    fn requeue(&mut self, n: usize, frame: &CanFrame) {
        let node = &mut self.nodes[n];
        let waiting = &mut node.transmit;
        match node.config.order {
            Order::Fifo => waiting.push_front(*frame),
            Order::Priority => {
                let at = waiting.partition_point(|w| w.id() < frame.id());
                if waiting.get(at).is_none_or(|w| w.id() != frame.id()) {
                    waiting.insert(at, *frame);
                }
            }
        }
        self.refresh(n);
    }
}
