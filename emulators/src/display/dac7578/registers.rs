//! The bus face: addresses, the command and access byte, data bytes (data sheet, "DACx578 I2C update sequence" and the
//! tables of commands). Every call comes at the instant of its ACK.

use palpate_core::codec::dac7578 as map;

use super::Dac7578;
use crate::time::Nanos;

/// State of the current message for this chip.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) enum Message {
    /// A message for another chip.
    #[default]
    Idle,
    /// Addressed for writing; the command and access byte comes first.
    Command,
    /// Data for that command: its high byte, once it has come. Pairs may follow each other [example 4].
    Data(Option<u8>),
    /// Addressed for reading; `true` once the high byte is out.
    Read(bool),
}

impl Dac7578 {
    /// Tells whether the chip answers to the 7-bit `address`: its own, and the broadcast address for writing.
    pub fn answers(&self, address: u8, read: bool) -> bool {
        let broadcast = address == map::BROADCAST_ADDRESS && !read;
        self.powered && (address == self.address || broadcast)
    }

    /// START or repeated START with an address byte; returns the ACK.
    pub fn start(&mut self, at: Nanos, address: u8, read: bool) -> bool {
        self.pass(at);
        self.message = match (self.answers(address, read), read) {
            (false, _) => Message::Idle,
            (true, true) => Message::Read(false),
            (true, false) => Message::Command,
        };
        self.message != Message::Idle
    }

    /// A byte from the controller; returns the ACK. Each byte of a message to this chip has one.
    pub fn write(&mut self, at: Nanos, byte: u8) -> bool {
        self.pass(at);
        match self.message {
            Message::Idle | Message::Read(_) => return false,
            Message::Command => {
                self.access = byte;
                self.message = Message::Data(None);
            }
            Message::Data(None) => self.message = Message::Data(Some(byte)),
            Message::Data(Some(high)) => {
                self.message = Message::Data(None);
                self.execute(u16::from_be_bytes([high, byte]));
                self.settle();
            }
        }
        true
    }

    /// A byte to the controller. 0xFF, an undriven bus, if the chip is not being read.
    pub fn read(&mut self, at: Nanos) -> u8 {
        self.pass(at);
        let Message::Read(second) = self.message else {
            return 0xFF;
        };
        self.message = Message::Read(!second);
        self.register().to_be_bytes()[usize::from(second)]
    }

    /// STOP: a command without all of its data is dropped.
    pub fn stop(&mut self, at: Nanos) {
        self.pass(at);
        self.message = Message::Idle;
    }

    /// Value that a read after the last command and access byte returns; 0 where there is nothing to read.
    fn register(&self) -> u16 {
        let slot = self.slots.get(usize::from(self.access & map::ALL));
        match self.access & !map::ALL {
            map::WRITE => slot.map_or(0, |slot| map::data(slot.input)),
            map::UPDATE => slot.map_or(0, |slot| map::data(slot.dac)),
            map::POWER => {
                let down = self.slots.iter().enumerate();
                down.fold(0, |all, (n, slot)| all | u16::from(slot.power != 0) << n)
            }
            map::CLEAR_CODE => u16::from(self.clear_code) << 4,
            map::LDAC => u16::from(self.no_pin),
            _ => 0,
        }
    }

    /// Executes a whole command.
    fn execute(&mut self, data: u16) {
        let (command, access) = (self.access & !map::ALL, self.access & map::ALL);
        let channels = match access {
            map::ALL => 0..self.slots.len(),
            one if one < map::CHANNELS => usize::from(one)..usize::from(one) + 1,
            _ if command <= map::WRITE_UPDATE => {
                self.invalid += 1;
                return;
            }
            _ => 0..0,
        };
        match command {
            map::WRITE | map::WRITE_UPDATE | map::WRITE_UPDATE_ALL => {
                let ldac_low = self.ldac_low;
                for number in channels {
                    let transparent = ldac_low || self.no_pin >> number & 1 == 1;
                    let slot = &mut self.slots[number];
                    slot.input = map::code(data.to_be_bytes());
                    if transparent || command == map::WRITE_UPDATE {
                        slot.load(slot.input);
                    }
                }
                if command == map::WRITE_UPDATE_ALL {
                    self.slots.iter_mut().for_each(|slot| slot.load(slot.input));
                }
            }
            map::UPDATE => {
                let slots = &mut self.slots[channels];
                slots.iter_mut().for_each(|slot| slot.load(slot.input));
            }
            map::POWER => {
                let mode = (data >> 13 & 3) as u8;
                for (number, slot) in self.slots.iter_mut().enumerate() {
                    if data >> 5 >> number & 1 == 1 {
                        slot.power = mode;
                    }
                }
            }
            map::CLEAR_CODE => self.clear_code = (data >> 4 & 3) as u8,
            map::LDAC => self.no_pin = (data >> 8) as u8,
            map::RESET => self.reset(),
            _ => self.invalid += 1,
        }
    }
}
