//! The bus face: addresses, the control register, the register file (data sheet 7.1 .. 7.3, 7.6).
//!
//! Every call comes at the instant of its ACK. The chip lets its own time pass up to there first.

use palpate_core::codec::pca9685 as map;
use palpate_core::codec::pca9685::{FULL, mode1, mode2};

use super::{Hazard, Pca9685, count};
use crate::time::Nanos;

/// State of the current message for this chip.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
enum Message {
    /// A message for another chip, or a refused one.
    #[default]
    Idle,
    /// Addressed for writing; the control register comes first.
    Control,
    /// Data for the register at the pointer.
    Data,
    /// Addressed for reading.
    Read,
    /// General call; the next byte must be 0x06.
    GeneralCall,
    /// Software reset: executed by STOP, called off by anything else.
    ResetArmed,
}

/// The chip's side of the bus.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Bus {
    message: Message,
    /// The control register [7.2].
    pointer: u8,
}

impl Pca9685 {
    /// Tells whether the chip answers to the 7-bit `address` now: its own, all-call, or an enabled sub-address [7.1];
    /// the general call for writing only.
    pub fn answers(&self, address: u8, read: bool) -> bool {
        if !self.powered {
            return false;
        }
        let enabled = [mode1::SUB1, mode1::SUB2, mode1::SUB3, mode1::ALLCALL];
        let shared = (enabled.iter().zip(&self.addresses))
            .any(|(bit, register)| self.mode1 & bit != 0 && register >> 1 == address);
        let general_call = address == map::SOFTWARE_RESET.0 && !read;
        address == self.config.address || general_call || shared
    }

    /// START or repeated START with an address byte; returns the ACK. Calls off a software reset.
    pub fn start(&mut self, at: Nanos, address: u8, read: bool) -> bool {
        self.act(at);
        self.bus.message = if !self.answers(address, read) {
            Message::Idle
        } else if read {
            Message::Read
        } else if address == map::SOFTWARE_RESET.0 {
            Message::GeneralCall
        } else {
            Message::Control
        };
        self.bus.message != Message::Idle
    }

    /// A byte from the controller; returns the ACK.
    pub fn write(&mut self, at: Nanos, byte: u8) -> bool {
        self.act(at);
        self.bus.message = match self.bus.message {
            Message::Control if is_register(byte) => {
                self.bus.pointer = byte;
                Message::Data
            }
            Message::Data => {
                self.store(self.bus.pointer, byte);
                self.increment();
                Message::Data
            }
            Message::GeneralCall if byte == map::SOFTWARE_RESET.1 => Message::ResetArmed,
            _ => Message::Idle,
        };
        self.bus.message != Message::Idle
    }

    /// A byte to the controller. 0xFF, an undriven bus, if the chip is not being read.
    pub fn read(&mut self, at: Nanos) -> u8 {
        self.act(at);
        if self.bus.message != Message::Read {
            return 0xFF;
        }
        let byte = self.register(self.bus.pointer);
        self.increment();
        byte
    }

    /// STOP: commits LED registers (OCH = 0) and executes a software reset. A repeated START does neither.
    pub fn stop(&mut self, at: Nanos) {
        self.act(at);
        if self.bus.message == Message::ResetArmed {
            self.reset();
        } else {
            self.bus.message = Message::Idle;
            if self.mode2 & mode2::OCH == 0 {
                self.commit(|written| written != 0);
            }
        }
        self.settle();
    }

    /// Value that the register at `address` reads; 0 where there is none. Reading changes nothing.
    pub fn register(&self, address: u8) -> u8 {
        match address {
            map::MODE1 => self.mode1 | if self.restart { mode1::RESTART } else { 0 },
            map::MODE2 => self.mode2,
            map::SUBADR1..=map::ALLCALLADR => self.addresses[usize::from(address - map::SUBADR1)],
            map::LED0_ON_L..=map::LED15_OFF_H => {
                let offset = address - map::LED0_ON_L;
                self.channels[usize::from(offset / 4)].registers[usize::from(offset % 4)]
            }
            map::PRE_SCALE => self.pre,
            _ => 0, // ALL_LED reads zero [7.3.4]; TESTMODE is not modelled
        }
    }

    fn store(&mut self, address: u8, value: u8) {
        match address {
            map::MODE1 => self.write_mode1(value),
            map::MODE2 => {
                self.mode2 = value & (mode2::INVRT | mode2::OCH | mode2::OUTDRV | mode2::OUTNE);
                self.look_for_oe_hazard();
            }
            map::SUBADR1..=map::ALLCALLADR => {
                // The lowest bit is read only [7.3.6, 7.3.7].
                self.addresses[usize::from(address - map::SUBADR1)] = value & 0xFE;
            }
            map::LED0_ON_L..=map::LED15_OFF_H => {
                let offset = address - map::LED0_ON_L;
                self.store_led(usize::from(offset / 4), usize::from(offset % 4), value);
            }
            map::ALL_LED_ON_L..=map::ALL_LED_OFF_H => {
                for n in 0..self.channels.len() {
                    self.store_led(n, usize::from(address - map::ALL_LED_ON_L), value);
                }
            }
            map::PRE_SCALE if self.mode1 & mode1::SLEEP != 0 => self.pre = value.max(3),
            map::TESTMODE => self.hazard(Hazard::TestRegisterWritten),
            _ => {}
        }
        if self.mode2 & mode2::OCH != 0 {
            self.commit(|written| written == 0b1111);
        }
        self.settle();
    }

    fn store_led(&mut self, n: usize, register: usize, value: u8) {
        let channel = &mut self.channels[n];
        // The upper three bits of ON_H and OFF_H cannot be written [7.3.3].
        let mask = if register % 2 == 1 { FULL | 0x0F } else { 0xFF };
        channel.registers[register] = value & mask;
        channel.written |= 1 << register;
    }

    /// Takes over the channels whose set of written registers is `ready`, all at once.
    fn commit(&mut self, ready: impl Fn(u8) -> bool) {
        let count = self.counter.as_ref().map(|c| count(c.tick));
        let mut any = false;
        for channel in &mut self.channels {
            if ready(channel.written) {
                any = true;
                channel.commit();
                if let Some(count) = count {
                    channel.update(self.config.updates, count);
                }
            }
        }
        if any {
            self.led_committed();
        }
    }

    /// Auto-increment [7.2]: 45 to 00, FE to 00.
    fn increment(&mut self) {
        if self.mode1 & mode1::AI != 0 {
            self.bus.pointer = match self.bus.pointer {
                map::LED15_OFF_H | map::PRE_SCALE => map::MODE1,
                pointer => pointer.wrapping_add(1),
            };
        }
    }
}

/// Tells whether a control byte names a register: 46..F9 are not acknowledged [7.3, table 4].
const fn is_register(byte: u8) -> bool {
    byte <= map::LED15_OFF_H || byte >= map::ALL_LED_ON_L
}
