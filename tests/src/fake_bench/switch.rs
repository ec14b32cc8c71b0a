//! A switch with drivers of motors behind it, as a bus sees them: no time passes here. Registers are those of the emulated
//! chips; GO has ended as soon as it is written.

use palpate_core::codec::{drv2605, tca9548a};
use palpate_emulators::haptic::drv2605::registers::{Settings, WRITABLE};

use super::chip::{CHANNELS, Widths};

/// Drivers behind a switch.
const DRIVERS: usize = tca9548a::CHANNELS as usize;
/// A driver's registers, its pointer, and whether it is there.
const DRIVER_BYTES: usize = drv2605::COUNT + 2;
/// Eight bytes at a time, a switch with its address, what was written to it, whether it is stuck, and its drivers.
pub const SWITCH_WORDS: usize = (3 + DRIVERS * DRIVER_BYTES).div_ceil(8);

/// A driver.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Driver {
    is_there: bool,
    pointer: u8,
    registers: [u8; drv2605::COUNT],
}

impl Driver {
    const RESET: Self = Self {
        is_there: false,
        pointer: 0,
        registers: drv2605::RESET,
    };

    /// The level at which it drives its motor, 0 to 127.
    fn level(&self) -> u16 {
        let mode = self.registers[usize::from(drv2605::MODE)];
        if mode != drv2605::mode::REAL_TIME {
            return 0;
        }
        let level = self.registers[usize::from(drv2605::RTP_INPUT)];
        let share = Settings(&self.registers).asked(level);
        (share.abs() * 127.0).round() as u16
    }

    fn write(&mut self, bytes: &[u8]) {
        let Some((&first, values)) = bytes.split_first() else {
            return;
        };
        self.pointer = first;
        for &value in values {
            let register = usize::from(self.pointer);
            if let (Some(slot), Some(mask)) =
                (self.registers.get_mut(register), WRITABLE.get(register))
            {
                *slot = *slot & !mask | value & mask;
            }
            self.registers[usize::from(drv2605::GO)] = 0;
            self.pointer = self.pointer.wrapping_add(1);
        }
    }

    /// A message from it: a bit that it lets low is low.
    fn read(&mut self, bytes: &mut [u8]) {
        for byte in bytes {
            let value = self.registers.get(usize::from(self.pointer));
            *byte &= value.copied().unwrap_or(0);
            self.pointer = self.pointer.wrapping_add(1);
        }
    }
}

/// A switch and the drivers behind it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Switch {
    /// Address on the bus; zero for a bench without a switch.
    address: u8,
    /// Byte that was written to it last, as it reads back.
    control: u8,
    /// Channels that are connected whatever is written; zero for a switch that works.
    pub stuck: u8,
    drivers: [Driver; DRIVERS],
}

impl Switch {
    /// No switch.
    pub const NONE: Self = Self {
        address: 0,
        control: 0,
        stuck: 0,
        drivers: [Driver::RESET; DRIVERS],
    };

    /// A switch that has just got its supply, with so many drivers.
    pub fn new(address: u8, drivers: usize) -> Self {
        let mut switch = Self::NONE;
        switch.address = address;
        for driver in switch.drivers.iter_mut().take(drivers) {
            driver.is_there = true;
        }
        switch
    }

    /// Takes a driver off its channel.
    pub fn unplug(&mut self, channel: usize) {
        self.drivers[channel].is_there = false;
    }

    /// The level of each driver by its channel, 0 to 127.
    pub fn levels(&self) -> Widths {
        let mut levels = [0; CHANNELS];
        for (level, driver) in levels.iter_mut().zip(&self.drivers) {
            *level = driver.level();
        }
        levels
    }

    /// One message to or from it, or what is behind it; whether anything acknowledges it.
    pub fn exchange(&mut self, address: u8, reads: bool, bytes: &mut [u8]) -> bool {
        if self.address == 0 {
            return false;
        }
        if address == self.address {
            match (reads, bytes.last()) {
                (true, _) => bytes.fill(self.control),
                (false, Some(control)) => self.control = *control,
                (false, None) => {}
            }
            return true;
        }
        if address != drv2605::ADDRESS {
            return false;
        }
        let open = match self.stuck {
            0 => self.control,
            stuck => stuck,
        };
        if reads {
            bytes.fill(0xFF);
        }
        let mut is_heard = false;
        for (channel, driver) in self.drivers.iter_mut().enumerate() {
            if open >> channel & 1 == 0 || !driver.is_there {
                continue;
            }
            is_heard = true;
            match reads {
                true => driver.read(bytes),
                false => driver.write(bytes),
            }
        }
        is_heard
    }

    pub(super) fn words(&self) -> [u64; SWITCH_WORDS] {
        let mut bytes = [0; SWITCH_WORDS * 8];
        bytes[..3].copy_from_slice(&[self.address, self.control, self.stuck]);
        let places = bytes[3..].as_chunks_mut::<DRIVER_BYTES>().0;
        for (driver, place) in self.drivers.iter().zip(places) {
            (place[0], place[1]) = (u8::from(driver.is_there), driver.pointer);
            place[2..].copy_from_slice(&driver.registers);
        }
        let mut words = [0; SWITCH_WORDS];
        for (word, bytes) in words.iter_mut().zip(bytes.as_chunks::<8>().0) {
            *word = u64::from_ne_bytes(*bytes);
        }
        words
    }

    pub(super) fn of_words(words: &[u64]) -> Self {
        let mut bytes = [0; SWITCH_WORDS * 8];
        for (bytes, word) in bytes.as_chunks_mut::<8>().0.iter_mut().zip(words) {
            *bytes = word.to_ne_bytes();
        }
        let mut switch = Self::NONE;
        [switch.address, switch.control, switch.stuck] = [bytes[0], bytes[1], bytes[2]];
        let places = bytes[3..].as_chunks::<DRIVER_BYTES>().0;
        for (driver, place) in switch.drivers.iter_mut().zip(places) {
            (driver.is_there, driver.pointer) = (place[0] != 0, place[1]);
            driver.registers.copy_from_slice(&place[2..]);
        }
        switch
    }
}
