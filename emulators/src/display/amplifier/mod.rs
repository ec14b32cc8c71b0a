//! Current amplifiers: a pin in, the current that a wire is to get out. [`supply`] has the current that it truly gets.

pub mod supply;

use palpate_core::codec::dac7578::FULL_SCALE;
use palpate_core::codec::pca9685::CHANNELS;
use palpate_core::units::{Channel, Milliamps};

use crate::display::pca9685::{Edge, Pin};
use crate::time::Nanos;

/// Properties of a bench's amplifiers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AmplifierConfig {
    /// Current of a wire that is on, while the supply has it; at a converter's full scale, where there is one.
    pub current: Milliamps,
    /// Error of the current that a converter sets; `None` where the current is fixed.
    pub set: Option<SetError>,
    /// Time from no current to all of it, and back; linear.
    pub rise: Nanos,
    /// Resistance of a transistor that is on, in series with its wire, Ohm.
    pub on_ohm: f64,
}

/// Error of an amplifier's current against the one that its converter sets.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SetError {
    /// Ratio of the current that flows to the current that was set.
    pub gain: f64,
    /// Current that flows besides, mA; negative where less flows.
    pub offset_ma: f64,
}

impl SetError {
    /// The current that flows for a code, of amplifiers that are to give `full` at the largest; none runs backwards.
    pub fn current(&self, full: Milliamps, code: u16) -> Milliamps {
        let set = f64::from(full.0) * f64::from(code) / f64::from(FULL_SCALE);
        Milliamps((set * self.gain + self.offset_ma).max(0.0).round() as u32)
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

/// A change of the current that a wire is to get.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Current {
    /// Time of the change.
    pub at: Nanos,
    /// Channel of the wire.
    pub channel: Channel,
    /// The current from then on, if the supply has it.
    pub current: Milliamps,
}

/// Time at which an edge of the pin takes effect behind an amplifier whose current rises and
/// falls linearly in `rise`. The ramp counts as the one instant that puts the same energy
/// into the wire: two thirds of it on the way up, where the square of the current is small at
/// first, one third on the way down. A pulse shorter than a third of the rise gives nothing.
pub(crate) fn takes_effect(edge: &Edge, rise: Nanos) -> Nanos {
    let part = if edge.pin == Pin::High { 2 } else { 1 };
    edge.at + Nanos(rise.0 * part / 3)
}

/// Time from the start of a linear ramp between two currents to its effect: the one instant that puts the same energy
/// into the wire. The whole way, from zero to full current, takes `rise`. A ramp from zero takes effect at two thirds,
/// a ramp to zero at one third.
pub fn settles(was: Milliamps, is: Milliamps, rise: Nanos) -> Nanos {
    let (was, is) = (u64::from(was.0), u64::from(is.0));
    let both = (was + is).max(1);
    Nanos(rise.0 * (2 * is + was) / (3 * both))
}

#[derive(Clone, Copy, Debug)]
struct Output {
    pin: Pin,
    /// Current while the output conducts.
    peak: Milliamps,
    fault: Option<AmplifierFault>,
}

impl Output {
    fn conducts(&self) -> bool {
        match self.fault {
            Some(AmplifierFault::StuckOn) => true,
            Some(AmplifierFault::OpenWire) => false,
            None => self.pin == Pin::High,
        }
    }

    fn flows(&self) -> Milliamps {
        if self.conducts() {
            self.peak
        } else {
            Milliamps(0)
        }
    }
}

/// The amplifiers behind one chip.
#[derive(Clone, Debug)]
pub struct Amplifier {
    outputs: [Output; CHANNELS as usize],
}

impl Amplifier {
    /// Sixteen outputs that give `peak` while their pin is high. Inputs are pulled down: a chip that lets go of one
    /// switches it off, as on any board for hot wires.
    pub fn new(peak: Milliamps) -> Self {
        let output = Output {
            pin: Pin::Low,
            peak,
            fault: None,
        };
        Self {
            outputs: [output; CHANNELS as usize],
        }
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

    /// Sets what one output gives while its pin is high; returns the change of current, if there is one.
    pub fn set(&mut self, at: Nanos, channel: Channel, peak: Milliamps) -> Option<Current> {
        self.change(at, channel, |output| output.peak = peak)
    }

    /// Current that one output is set to now, whether or not it gives it.
    pub fn peak(&self, channel: Channel) -> Milliamps {
        let output = self.outputs.get(usize::from(channel.0));
        output.map_or(Milliamps(0), |output| output.peak)
    }

    /// The current through one wire now.
    pub fn current(&self, channel: Channel) -> Milliamps {
        let output = self.outputs.get(usize::from(channel.0));
        output.map_or(Milliamps(0), Output::flows)
    }

    /// Current that all outputs of this board together are to give now.
    pub fn sum(&self) -> Milliamps {
        Milliamps((self.outputs.iter()).fold(0, |sum, o| sum.saturating_add(o.flows().0)))
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
}

#[cfg(test)]
mod tests;
