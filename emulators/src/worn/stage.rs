//! The amplifiers of a display: when pins and converters take effect in them.

use palpate_core::units::{Channel, Milliamps};

use crate::display::amplifier::{
    Amplifier, AmplifierConfig, AmplifierFault, settles, takes_effect,
};
use crate::display::dac7578::Level;
use crate::display::i2c::Error as I2cError;
use crate::display::pca9685::{Edge, Pin};
use crate::time::Nanos;

use super::WirePlace;
use super::rack::Connection;

/// Change of an amplifier's input.
#[derive(Clone, Copy, Debug)]
enum Change {
    /// A pin goes high or low.
    Pin(Edge),
    /// Another current from now on, while that pin is high.
    Peak(Channel, Milliamps),
}

/// The amplifiers, a set of sixteen for each chip.
#[derive(Debug)]
pub(super) struct Stage {
    amplifiers: Vec<Amplifier>,
    config: AmplifierConfig,
    /// Changes of the converters of one step, in the order of time: the same memory for every step.
    levels: Vec<(usize, Level)>,
    /// Changes that have yet to take effect: when, and in which chip's amplifiers.
    rising: Vec<(Nanos, usize, Change)>,
}

impl Stage {
    pub(super) fn new(config: AmplifierConfig, boards: usize) -> Self {
        let rest = config
            .set
            .map_or(config.current, |set| set.current(config.current, 0));
        Self {
            amplifiers: vec![Amplifier::new(rest); boards],
            config,
            levels: Vec::new(),
            rising: Vec::new(),
        }
    }

    /// Takes an edge of a chip.
    pub(super) fn edge(&mut self, board: usize, edge: Edge) {
        let at = takes_effect(&edge, self.config.rise);
        if edge.pin != Pin::High {
            // A pulse shorter than a third of the rise gives nothing: its end would take effect before its beginning, which
            // would then stay.
            self.rising.retain(|(then, on, change)| {
                let begins = matches!(change, Change::Pin(e) if e.channel == edge.channel && e.pin == Pin::High);
                !(begins && *on == board && *then > at)
            });
        }
        self.rising.push((at, board, Change::Pin(edge)));
    }

    /// Takes the levels that converters set until `to`; the amplifiers follow in their rise time.
    ///
    /// # Errors
    /// The errors of [`Connection::take_levels`].
    pub(super) fn follow(&mut self, chips: &Connection, to: Nanos) -> Result<(), I2cError> {
        let Some(set) = self.config.set else {
            return Ok(());
        };
        chips.take_levels(to, &mut self.levels)?;
        for (board, level) in self.levels.drain(..) {
            let is = set.current(self.config.current, level.code);
            let amplifier = self.amplifiers.get(board);
            let was = amplifier.map_or(Milliamps(0), |a| a.peak(level.channel));
            let at = level.at + settles(was, is, self.config.rise);
            self.rising
                .push((at, board, Change::Peak(level.channel, is)));
        }
        Ok(())
    }

    /// Number of changes that take effect until `to`.
    pub(super) fn due(&mut self, to: Nanos) -> usize {
        self.rising.sort_by_key(|(at, ..)| *at);
        self.rising.partition_point(|(at, ..)| *at <= to)
    }

    /// Lets one of those changes take effect; returns when, if it changes what a wire is to get.
    pub(super) fn apply(&mut self, index: usize) -> Option<Nanos> {
        let (at, board, change) = *self.rising.get(index)?;
        let amplifier = self.amplifiers.get_mut(board)?;
        let changed = match change {
            Change::Pin(edge) => amplifier.edge(edge),
            Change::Peak(channel, peak) => amplifier.set(at, channel, peak),
        };
        changed.map(|_| at)
    }

    /// Drops the first `count` changes, which have taken effect.
    pub(super) fn done(&mut self, count: usize) {
        self.rising.drain(..count);
    }

    /// Current that the wire at a place is to get now.
    pub(super) fn current(&self, place: &WirePlace) -> Milliamps {
        let amplifier = self.amplifiers.get(usize::from(place.board));
        amplifier.map_or(Milliamps(0), |a| a.current(Channel(place.channel)))
    }

    /// Breaks or repairs the amplifier at a place; returns whether that changes what its wire is to get.
    pub(super) fn set_fault(
        &mut self,
        at: Nanos,
        place: &WirePlace,
        fault: Option<AmplifierFault>,
    ) -> bool {
        let amplifier = self.amplifiers.get_mut(usize::from(place.board));
        let channel = Channel(place.channel);
        amplifier
            .and_then(|a| a.set_fault(at, channel, fault))
            .is_some()
    }
}

#[cfg(test)]
#[path = "stage_tests.rs"]
mod tests;
