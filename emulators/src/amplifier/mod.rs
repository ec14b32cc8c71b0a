//! Current amplifiers: a pin in, the current that a wire is to get out. [`supply`] says what it truly gets.

pub mod supply;

use palpate_core::units::{Channel, Milliamps};
use palpate_core::wire::pca9685::CHANNELS;

use crate::pca9685::{Edge, Pin};
use crate::time::Nanos;

/// What the amplifiers of a bench are like.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AmplifierConfig {
    /// Current of a wire that is on, while the supply has it.
    pub current: Milliamps,
    /// From no current to all of it, and back; linear.
    pub rise: Nanos,
    /// Resistance of a transistor that is on, in series with its wire, Ohm.
    pub on_ohm: f64,
}

impl AmplifierConfig {
    /// Instant and without loss: this current or none.
    pub const fn ideal(current: Milliamps) -> Self {
        Self {
            current,
            rise: Nanos::ZERO,
            on_ohm: 0.0,
        }
    }
}

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

/// A change of the current that a wire is to get.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Current {
    /// When.
    pub at: Nanos,
    /// Which wire.
    pub channel: Channel,
    /// The current from then on, if the supply has it.
    pub current: Milliamps,
}

/// When an edge of the pin takes effect behind an amplifier whose current rises and falls linearly in
/// `rise`. The ramp is told as the one instant that puts the same energy into the wire: two thirds of it on the
/// way up, where the square of the current is small at first, one third on the way down. A pulse shorter
/// than a third of the rise gives nothing.
pub fn takes_effect(edge: &Edge, rise: Nanos) -> Nanos {
    let part = if edge.pin == Pin::High { 2 } else { 1 };
    edge.at + Nanos(rise.0 * part / 3)
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

    /// What all outputs of this board are to give now.
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
    fn a_ramp_gives_the_energy_of_its_equivalent_edges() {
        let rise = Nanos(3000);
        let on = takes_effect(&edge(0, 0, Pin::High), rise);
        let off = takes_effect(&edge(100_000, 0, Pin::Low), rise);
        // Integral of the squared current over both ramps and what lies between, per squared full current.
        let steps = 300_000;
        let true_ns: f64 = (0..steps)
            .map(|i| (f64::from(i) + 0.5) * 103_000.0 / f64::from(steps))
            .map(|t| (t / 3000.0).min(1.0).min((103_000.0 - t) / 3000.0))
            .map(|part| part * part * 103_000.0 / f64::from(steps))
            .sum();
        assert!((true_ns - off.since(on).0 as f64).abs() < 0.1, "{true_ns}");
    }
}
