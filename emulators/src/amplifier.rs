//! Current amplifiers: a pin in, a wire's current out, and what the supply gives for all of them.
//!
//! Ideal for now: the set current or none, at the edge's own nanosecond. Rise time, on-resistance and
//! sagging supplies get their fields when they do something.

use palpate_core::units::{Channel, Milliamps};
use palpate_core::wire::pca9685::CHANNELS;

use crate::pca9685::{Edge, Pin};
use crate::time::Nanos;

/// A defect of one output.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum AmplifierFault {
    /// The transistor conducts whatever the pin says.
    StuckOn,
    /// The wire or its plug is broken: no current.
    OpenWire,
}

/// What an input does when the chip lets go of it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Pull {
    /// Pulled down: off. What a board for hot wires has.
    #[default]
    Down,
    /// Pulled up: on.
    Up,
}

/// A change of a wire's current.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Current {
    /// When.
    pub at: Nanos,
    /// Which wire.
    pub channel: Channel,
    /// The current from then on.
    pub current: Milliamps,
}

#[derive(Clone, Copy, Debug)]
struct Output {
    peak: Milliamps,
    pin: Pin,
    fault: Option<AmplifierFault>,
}

/// The amplifiers behind one chip.
#[derive(Clone, Debug)]
pub struct Amplifier {
    outputs: [Output; CHANNELS as usize],
    pull: Pull,
}

impl Amplifier {
    /// Sixteen outputs that give `peak` while their pin is high.
    pub fn new(peak: Milliamps, pull: Pull) -> Self {
        let output = Output {
            peak,
            pin: Pin::Low,
            fault: None,
        };
        Self {
            outputs: [output; CHANNELS as usize],
            pull,
        }
    }

    /// Sets the current of one wire; returns the change at `at` if it is on.
    pub fn set_peak(&mut self, at: Nanos, channel: Channel, peak: Milliamps) -> Option<Current> {
        self.change(at, channel, |output| output.peak = peak)
    }

    /// Breaks or repairs one output.
    pub fn set_fault(
        &mut self,
        at: Nanos,
        channel: Channel,
        fault: Option<AmplifierFault>,
    ) -> Option<Current> {
        self.change(at, channel, |output| output.fault = fault)
    }

    /// Takes an edge of the chip; returns the change of current, if there is one.
    pub fn edge(&mut self, edge: Edge) -> Option<Current> {
        self.change(edge.at, edge.channel, |output| output.pin = edge.pin)
    }

    /// The current through one wire now.
    pub fn current(&self, channel: Channel) -> Milliamps {
        let output = self.outputs.get(usize::from(channel.0));
        output.map_or(Milliamps(0), |output| self.flows(output))
    }

    /// What all wires of this board take now.
    pub fn sum(&self) -> Milliamps {
        Milliamps((self.outputs.iter()).fold(0, |sum, o| sum.saturating_add(self.flows(o).0)))
    }

    fn change(
        &mut self,
        at: Nanos,
        channel: Channel,
        work: impl FnOnce(&mut Output),
    ) -> Option<Current> {
        let was = self.current(channel);
        work(self.outputs.get_mut(usize::from(channel.0))?);
        let current = self.current(channel);
        (current != was).then_some(Current {
            at,
            channel,
            current,
        })
    }

    fn flows(&self, output: &Output) -> Milliamps {
        let on = match (output.fault, output.pin) {
            (Some(AmplifierFault::StuckOn), _) => true,
            (Some(AmplifierFault::OpenWire), _) => false,
            (None, Pin::HighZ) => self.pull == Pull::Up,
            (None, pin) => pin == Pin::High,
        };
        if on { output.peak } else { Milliamps(0) }
    }
}

/// The supply behind any number of boards: its current and the peak of it.
///
/// Changes at the same nanosecond count together: one wire off and the next one on is no peak.
#[derive(Clone, Copy, Debug, Default)]
pub struct Supply {
    now: Milliamps,
    at: Nanos,
    peak: Milliamps,
    peak_at: Nanos,
}

impl Supply {
    /// The sum over all boards from `at` on. Times do not go backwards.
    pub fn set(&mut self, at: Nanos, sum: Milliamps) {
        if at > self.at {
            self.settle();
            self.at = at;
        }
        self.now = sum;
    }

    /// What flows now.
    pub const fn current(&self) -> Milliamps {
        self.now
    }

    /// The largest current so far and when it first flowed.
    pub fn peak(&self) -> (Milliamps, Nanos) {
        let mut settled = *self;
        settled.settle();
        (settled.peak, settled.peak_at)
    }

    fn settle(&mut self) {
        if self.now > self.peak {
            (self.peak, self.peak_at) = (self.now, self.at);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn edge(at: u64, channel: u8, pin: Pin) -> Edge {
        Edge {
            at: Nanos(at),
            channel: Channel(channel),
            pin,
        }
    }

    #[test]
    fn a_high_pin_gives_the_set_current_and_nothing_else_does() {
        let mut amplifier = Amplifier::new(Milliamps(300), Pull::Down);
        let change = amplifier.edge(edge(5, 2, Pin::High));
        assert_eq!(change.map(|c| (c.at.0, c.current.0)), Some((5, 300)));
        assert_eq!(amplifier.edge(edge(6, 2, Pin::High)), None);
        assert_eq!(amplifier.sum(), Milliamps(300));
        assert!(amplifier.edge(edge(7, 2, Pin::HighZ)).is_some());
        assert_eq!(amplifier.sum(), Milliamps(0));
        assert_eq!(amplifier.edge(edge(8, 99, Pin::High)), None);
    }

    #[test]
    fn a_pulled_up_input_heats_when_the_chip_lets_go() {
        let mut amplifier = Amplifier::new(Milliamps(300), Pull::Up);
        amplifier.edge(edge(1, 0, Pin::HighZ));
        assert_eq!(amplifier.current(Channel(0)), Milliamps(300));
    }

    #[test]
    fn a_stuck_output_stays_on_and_an_open_wire_stays_cold() {
        let mut amplifier = Amplifier::new(Milliamps(300), Pull::Down);
        let stuck = amplifier.set_fault(Nanos(1), Channel(1), Some(AmplifierFault::StuckOn));
        assert_eq!(stuck.map(|c| c.current.0), Some(300));
        amplifier.set_fault(Nanos(1), Channel(2), Some(AmplifierFault::OpenWire));
        assert_eq!(amplifier.edge(edge(2, 2, Pin::High)), None);
        assert_eq!(amplifier.sum(), Milliamps(300));
        assert_eq!(
            amplifier
                .set_fault(Nanos(3), Channel(2), None)
                .map(|c| c.current.0),
            Some(300)
        );
    }

    #[test]
    fn the_supply_peak_is_over_all_wires_and_not_over_a_handover() {
        let mut amplifier = Amplifier::new(Milliamps(300), Pull::Down);
        let mut supply = Supply::default();
        for e in [
            edge(10, 0, Pin::High),
            edge(20, 1, Pin::High), // on and off in one nanosecond, in this order
            edge(20, 0, Pin::Low),
            edge(30, 2, Pin::High),
            edge(40, 1, Pin::Low),
        ] {
            amplifier.edge(e);
            supply.set(e.at, amplifier.sum());
            if e.at == Nanos(20) && e.channel == Channel(0) {
                assert_eq!(supply.peak(), (Milliamps(300), Nanos(10)));
            }
        }
        assert_eq!(supply.peak(), (Milliamps(600), Nanos(30)));
        assert_eq!(supply.current(), Milliamps(300));
    }
}
