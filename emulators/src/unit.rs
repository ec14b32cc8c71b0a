//! A driver unit in virtual time: its own program behind a network and a clock of its own, over emulated boards.

use std::collections::VecDeque;
use std::convert::Infallible;

use embedded_hal::digital::{ErrorType as PinErrorType, OutputPin};
use embedded_hal::i2c::I2c;
use palpate_core::codec::link::{Buffer, MOST};
use palpate_core::peltier::Regulator;
use palpate_core::units::Instant;
pub use palpate_unit::{Converters, Settings, SettingsError};
use palpate_unit::{Datagrams, Module, NoModule, Unit};

use crate::display::i2c::I2cHandle;
use crate::network::{Profile, Way};
use crate::time::Nanos;

/// Reading of the unit's clock at the start of the run, microseconds: the unit was switched on before.
const HEAD_START_US: u64 = 5_000_000;

/// The crystal of a unit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Crystal {
    /// Parts per million that it is fast; negative is slow.
    pub ppm: i32,
}

impl Crystal {
    fn rate(self) -> i128 {
        1_000_000 + i128::from(self.ppm)
    }

    /// Reading of the unit's clock at a time of the run.
    pub fn shows(self, at: Nanos) -> Instant {
        let passed = i128::from(at.0) * self.rate() / 1_000_000_000;
        Instant::from_micros(HEAD_START_US + passed as u64) // a positive rate keeps it positive
    }

    /// First time at which the unit's clock shows this.
    pub fn when(self, shown: Instant) -> Nanos {
        let passed = i128::from(shown.as_micros().saturating_sub(HEAD_START_US));
        let rate = self.rate();
        let ns = (passed * 1_000_000_000 + rate - 1) / rate;
        Nanos(u64::try_from(ns).unwrap_or(u64::MAX))
    }
}

/// The unit's line to the OE pins of all its chips.
#[derive(Clone, Debug)]
pub struct OeLine(pub I2cHandle);

impl OeLine {
    fn set(&self, high: bool) {
        // Refused only from inside another look at the segment, and there is none here.
        let _ = self.0.with(|segment| {
            for chip in segment.chips_mut() {
                chip.set_output_enable_pin(chip.now(), high);
            }
        });
    }
}

impl PinErrorType for OeLine {
    type Error = Infallible;
}

impl OutputPin for OeLine {
    fn set_low(&mut self) -> Result<(), Infallible> {
        self.set(false);
        Ok(())
    }

    fn set_high(&mut self) -> Result<(), Infallible> {
        self.set(true);
        Ok(())
    }
}

/// Datagrams that have landed at the unit, and those that it sends.
#[derive(Debug, Default)]
struct Radio {
    landed: VecDeque<Vec<u8>>,
    sent: Vec<Vec<u8>>,
}

impl Datagrams for Radio {
    type Peer = ();

    fn receive(&mut self, buffer: &mut Buffer) -> Option<(usize, ())> {
        let datagram = self.landed.pop_front()?;
        let length = datagram.len().min(MOST);
        buffer[..length].copy_from_slice(&datagram[..length]);
        Some((length, ()))
    }

    fn send(&mut self, datagram: &[u8], (): ()) {
        self.sent.push(datagram.to_vec());
    }
}

/// A unit, its network and its clock.
#[derive(Debug)]
pub struct EmulatedUnit<I, P, T = NoModule> {
    unit: Unit<I, P, T>,
    crystal: Crystal,
    there: Way,
    back: Way,
    radio: Radio,
    /// Time at which the unit's program last ran.
    now: Nanos,
}

impl<I: I2c, P: OutputPin> EmulatedUnit<I, P> {
    /// A unit that begins at once.
    ///
    /// # Errors
    /// [`SettingsError`] for settings that no unit can have.
    pub fn new(
        settings: &Settings<'_>,
        lines: (I, P),
        network: (Profile, Crystal),
        seed: u64,
    ) -> Result<Self, SettingsError> {
        Self::warming(settings, lines, None, network, seed)
    }
}

impl<I: I2c, P: OutputPin, T: Module> EmulatedUnit<I, P, T> {
    /// A unit with a Peltier module, if there is one, that begins at once.
    ///
    /// # Errors
    /// [`SettingsError`] for settings that no unit can have.
    pub fn warming(
        settings: &Settings<'_>,
        lines: (I, P),
        module: Option<(T, Regulator)>,
        (profile, crystal): (Profile, Crystal),
        seed: u64,
    ) -> Result<Self, SettingsError> {
        let mut unit = Unit::warming(settings, lines, module)?;
        unit.start(crystal.shows(Nanos::ZERO));
        Ok(Self {
            unit,
            crystal,
            there: Way::new(profile, seed, "network to the unit"),
            back: Way::new(profile, seed, "network from the unit"),
            radio: Radio::default(),
            now: Nanos::ZERO,
        })
    }

    /// The unit, to look at.
    pub const fn unit(&self) -> &Unit<I, P, T> {
        &self.unit
    }

    /// Crystal of the unit's clock.
    pub const fn crystal(&self) -> Crystal {
        self.crystal
    }

    /// Datagrams that the network lost, both ways.
    pub const fn lost(&self) -> u64 {
        self.there.lost() + self.back.lost()
    }

    /// Changes what the network does, both ways.
    pub const fn set_profile(&mut self, profile: Profile) {
        self.there.set_profile(profile);
        self.back.set_profile(profile);
    }

    /// Cuts the network, or opens it again.
    pub const fn set_cut(&mut self, cut: bool) {
        self.there.set_cut(cut);
        self.back.set_cut(cut);
    }

    /// A host sends a datagram at `now`.
    pub fn send(&mut self, now: Nanos, datagram: &[u8]) {
        self.there.send(now, datagram);
    }

    /// A datagram that has landed at the host by `now`.
    pub fn hear(&mut self, now: Nanos) -> Option<Vec<u8>> {
        self.back.land(now)
    }

    /// Time of the next event: a datagram lands at either end, or the unit's program is due.
    pub fn next(&self) -> Nanos {
        let due = self.crystal.when(self.unit.next()).max(self.now + Nanos(1));
        let landing = [self.there.next(), self.back.next()];
        landing.into_iter().flatten().fold(due, Nanos::min)
    }

    /// Lets the unit's program run at `now`, with what has landed. The boards have been advanced until here.
    pub fn run(&mut self, now: Nanos) {
        while let Some(datagram) = self.there.land(now) {
            self.radio.landed.push_back(datagram);
        }
        self.now = now;
        let shown = self.crystal.shows(now);
        // A turn takes a few datagrams at a time.
        loop {
            self.unit.turn(shown, &mut self.radio);
            if self.radio.landed.is_empty() {
                break;
            }
        }
        for datagram in self.radio.sent.drain(..) {
            self.back.send(now, &datagram);
        }
    }

    /// Switches the unit off and on: its program begins anew with another first challenge.
    ///
    /// # Errors
    /// [`SettingsError`] for settings that no unit can have.
    pub fn reset(&mut self, settings: &Settings<'_>, bus: I, cut: P) -> Result<(), SettingsError> {
        self.unit = Unit::warming(settings, (bus, cut), None)?;
        self.unit.start(self.crystal.shows(self.now));
        self.radio = Radio::default();
        Ok(())
    }
}

#[cfg(test)]
#[path = "unit_tests.rs"]
mod tests;
