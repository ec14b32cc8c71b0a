//! A TCA9548A at register level: eight switches between one bus and eight others (TI data sheet SCPS207).
//!
//! Its one register has a bit for each channel. A write takes effect at the STOP, so a transaction that opens a channel
//! cannot reach through it yet. With several channels open, chips of the same address hear the same bytes, and reads are a
//! wired AND.

use super::drv2605::Drv2605;
use crate::time::Nanos;

/// Number of channels.
pub const CHANNELS: usize = 8;

/// One emulated multiplexer with the chips behind it.
#[derive(Clone, Debug)]
pub struct Tca9548a {
    address: u8,
    /// Channels that are open, a bit each.
    open: u8,
    /// The register, as it reads back.
    control: u8,
    /// Byte of the present write.
    written: Option<u8>,
    /// True while the present message is the multiplexer's own.
    own: bool,
    stuck: bool,
    behind: [Vec<Drv2605>; CHANNELS],
    /// Chips that took part since the last STOP, by channel and place.
    involved: Vec<(usize, usize)>,
}

impl Tca9548a {
    /// A multiplexer as after power-on: every channel is closed. `address` is 0x70 to 0x77 by its pins.
    pub const fn new(address: u8) -> Self {
        Self {
            address,
            open: 0,
            control: 0,
            written: None,
            own: false,
            stuck: false,
            behind: [const { Vec::new() }; CHANNELS],
            involved: Vec::new(),
        }
    }

    /// Puts a chip behind a channel, 0 to 7. Another channel is taken modulo eight.
    #[must_use]
    pub fn with(mut self, channel: usize, chip: Drv2605) -> Self {
        self.behind[channel % CHANNELS].push(chip);
        self
    }

    /// The 7-bit address.
    pub const fn address(&self) -> u8 {
        self.address
    }

    /// Channels that are open, a bit each.
    pub const fn open(&self) -> u8 {
        self.open
    }

    /// Lets the switches stay where they are from now on, whatever is written and reads back; or repairs them.
    pub const fn set_stuck(&mut self, stuck: bool) {
        self.stuck = stuck;
    }

    /// A low pulse of the RESET pin: every channel closes.
    pub const fn reset(&mut self) {
        self.control = 0;
        if !self.stuck {
            self.open = 0;
        }
        self.written = None;
    }

    /// The chips behind it, by channel, to touch them.
    pub fn chips_mut(&mut self) -> impl Iterator<Item = (usize, &mut Drv2605)> {
        let each = self.behind.iter_mut().enumerate();
        each.flat_map(|(channel, chips)| chips.iter_mut().map(move |chip| (channel, chip)))
    }

    /// The chips behind it, by channel.
    pub fn chips(&self) -> impl Iterator<Item = (usize, &Drv2605)> {
        let each = self.behind.iter().enumerate();
        each.flat_map(|(channel, chips)| chips.iter().map(move |chip| (channel, chip)))
    }

    /// Lets time pass for every chip, behind open channels or closed ones.
    pub fn advance(&mut self, to: Nanos) {
        self.chips_mut().for_each(|(_, chip)| chip.advance(to));
    }

    /// Tells whether it, or a chip behind an open channel, answers to a 7-bit address.
    pub fn answers(&self, address: u8, read: bool) -> bool {
        let mut reached = self.chips().filter(|(channel, _)| self.is_open(*channel));
        address == self.address || reached.any(|(_, chip)| chip.answers(address, read))
    }

    const fn is_open(&self, channel: usize) -> bool {
        self.open & (1 << channel) != 0
    }

    /// START with an address byte; returns the ACK.
    pub fn start(&mut self, at: Nanos, address: u8, read: bool) -> bool {
        self.own = address == self.address;
        let mut acknowledged = self.own;
        for channel in 0..CHANNELS {
            if !self.is_open(channel) {
                continue;
            }
            for (place, chip) in self.behind[channel].iter_mut().enumerate() {
                let known = self.involved.contains(&(channel, place));
                if known || chip.answers(address, read) {
                    acknowledged |= chip.start(at, address, read);
                    if !known {
                        self.involved.push((channel, place));
                    }
                }
            }
        }
        acknowledged
    }

    /// A byte from the controller; returns the ACK. Of several bytes the last one counts.
    pub fn write(&mut self, at: Nanos, byte: u8) -> bool {
        if self.own {
            self.written = Some(byte);
        }
        let reached = self.involved.iter();
        reached.fold(self.own, |acknowledged, &(channel, place)| {
            acknowledged | self.behind[channel][place].write(at, byte)
        })
    }

    /// A byte to the controller: the register, again and again.
    pub fn read(&mut self, at: Nanos) -> u8 {
        let own = if self.own { self.control } else { 0xFF };
        let reached = self.involved.iter();
        reached.fold(own, |byte, &(channel, place)| {
            byte & self.behind[channel][place].read(at)
        })
    }

    /// STOP: channels open and close.
    pub fn stop(&mut self, at: Nanos) {
        for (channel, place) in self.involved.drain(..) {
            self.behind[channel][place].stop(at);
        }
        if let Some(control) = self.written.take() {
            self.control = control;
            if !self.stuck {
                self.open = control;
            }
        }
        self.own = false;
    }
}

#[cfg(test)]
#[path = "tca9548a_tests.rs"]
mod tests;
