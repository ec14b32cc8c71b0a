//! A DAC7578 at register level, in virtual time: TI data sheet SBAS496A; its sections in brackets.
//!
//! A state machine with two faces. The bus face ([`Dac7578::start`], [`Dac7578::write`], [`Dac7578::read`],
//! [`Dac7578::stop`]) is what a driver sees. The physical face moves LDAC, CLR and the supply, and reads the outputs.
//! [`Dac7578::take_levels`] gives every change of an output. How far the output buffer is from its code is the
//! amplifier's to say.

mod registers;

use std::collections::VecDeque;

use palpate_core::codec::dac7578::{CHANNELS, FULL_SCALE};
use palpate_core::units::Channel;

use crate::time::Nanos;
use registers::Message;

/// An output took another level.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Level {
    /// Time of the change: the end of the acknowledge bit of the last byte, or of a pin.
    pub at: Nanos,
    /// Output, 0 for A.
    pub channel: Channel,
    /// Code of the new level; 0 for an output that is powered down.
    pub code: u16,
}

/// Registers of a channel.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
struct Slot {
    /// Code that was written and waits for an update.
    input: u16,
    /// Code that the converter is loaded with.
    dac: u16,
    /// Power-down mode, 0 for on [power-down commands].
    power: u8,
    /// The DAC register keeps its code, whatever is written and acknowledged.
    stuck: bool,
}

impl Slot {
    fn load(&mut self, code: u16) {
        if !self.stuck {
            self.dac = code;
        }
    }
}

/// One emulated chip.
#[derive(Clone, Debug)]
pub struct Dac7578 {
    address: u8,
    powered: bool,
    slots: [Slot; CHANNELS as usize],
    /// Level that CLR loads: 0 zero scale, 1 half, 2 full, 3 nothing.
    clear_code: u8,
    /// Channels that do without the LDAC pin, a bit each.
    no_pin: u8,
    /// The LDAC pin.
    ldac_low: bool,
    /// The CLR pin.
    clr_low: bool,
    message: Message,
    /// The last command and access byte: what a read is about.
    access: u8,
    /// Commands that the data sheet does not list.
    invalid: u64,
    levels: [u16; CHANNELS as usize],
    outbox: VecDeque<Level>,
    now: Nanos,
}

impl Dac7578 {
    /// A chip as it is after power-on at the start of the run, its RSTSEL pin low: all outputs at zero [power-on reset]. Its
    /// LDAC pin is high and its CLR pin too.
    pub fn new(address: u8) -> Self {
        Self {
            address,
            powered: true,
            slots: [Slot::default(); CHANNELS as usize],
            clear_code: 0,
            no_pin: 0,
            ldac_low: false,
            clr_low: false,
            message: Message::Idle,
            access: 0,
            invalid: 0,
            levels: [0; CHANNELS as usize],
            outbox: VecDeque::new(),
            now: Nanos::ZERO,
        }
    }

    /// 7-bit address of the chip.
    pub const fn address(&self) -> u8 {
        self.address
    }

    /// The code that an output stands for now; 0 for one that does not exist.
    pub fn level(&self, channel: Channel) -> u16 {
        let level = self.levels.get(usize::from(channel.0));
        level.copied().unwrap_or(0)
    }

    /// Commands that the data sheet does not list; they changed nothing.
    pub const fn invalid(&self) -> u64 {
        self.invalid
    }

    /// Hands over every change of an output until `to` that was not handed over yet, in order of time.
    pub fn take_levels(&mut self, to: Nanos, sink: &mut impl FnMut(Level)) {
        while let Some(level) = self.outbox.pop_front_if(|level| level.at <= to) {
            sink(level);
        }
    }

    /// Drives the LDAC pin; its falling edge loads every channel that was written [LDAC functionality].
    pub fn set_ldac_pin(&mut self, at: Nanos, low: bool) {
        self.pass(at);
        if self.powered && low && !self.ldac_low {
            self.slots.iter_mut().for_each(|slot| slot.load(slot.input));
        }
        self.ldac_low = low;
        self.settle();
    }

    /// Drives the CLR pin; its falling edge loads the clear code everywhere [clear code register and CLR pin].
    pub fn set_clr_pin(&mut self, at: Nanos, low: bool) {
        self.pass(at);
        let code = match self.clear_code {
            0 => Some(0),
            1 => Some(FULL_SCALE / 2 + 1),
            2 => Some(FULL_SCALE),
            _ => None,
        };
        if let Some(code) = code.filter(|_| self.powered && low && !self.clr_low) {
            for slot in &mut self.slots {
                slot.input = code;
                slot.load(code);
            }
        }
        self.clr_low = low;
        self.settle();
    }

    /// Takes the supply away: outputs are pulled down behind it, the chip answers nothing and forgets everything.
    pub fn power_off(&mut self, at: Nanos) {
        self.pass(at);
        self.reset();
        self.powered = false;
        self.settle();
    }

    /// Gives the supply back: all outputs at zero [power-on reset].
    pub fn power_on(&mut self, at: Nanos) {
        self.pass(at);
        self.powered = true;
        self.reset();
        self.settle();
    }

    /// Lets a channel's DAC register keep its code from now on, whatever is written and acknowledged, or repairs it. A
    /// channel that does not exist is left alone.
    pub fn set_stuck(&mut self, channel: Channel, stuck: bool) {
        if let Some(slot) = self.slots.get_mut(usize::from(channel.0)) {
            slot.stuck = stuck;
        }
    }

    /// Turns a bit of a DAC register over, as a disturbance may; a channel or bit that does not exist is left alone.
    pub fn flip(&mut self, at: Nanos, channel: Channel, bit: u8) {
        self.pass(at);
        if let Some(slot) = self.slots.get_mut(usize::from(channel.0)) {
            slot.dac ^= (1_u16.checked_shl(bit.into()).unwrap_or(0)) & FULL_SCALE;
        }
        self.settle();
    }

    fn pass(&mut self, at: Nanos) {
        self.now = self.now.max(at);
    }

    /// Puts registers to their reset values, where they have any.
    fn reset(&mut self) {
        for slot in &mut self.slots {
            (slot.input, slot.power) = (0, 0);
            slot.load(0);
        }
        self.clear_code = 0;
        self.no_pin = 0;
        self.message = Message::Idle;
        self.access = 0;
    }

    /// Puts the codes that the channels hold on the outputs, now.
    fn settle(&mut self) {
        for (number, (slot, level)) in (0..).zip(self.slots.iter().zip(&mut self.levels)) {
            let code = match slot.power {
                0 if self.powered => slot.dac,
                _ => 0,
            };
            if code != *level {
                *level = code;
                self.outbox.push_back(Level {
                    at: self.now,
                    channel: Channel(number),
                    code,
                });
            }
        }
    }
}

#[cfg(test)]
mod tests;
