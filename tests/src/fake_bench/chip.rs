//! Registers of PCA9685 chips as a bus sees them: no time passes here.

use palpate_core::codec::pca9685 as regs;
use palpate_core::codec::pca9685::mode1;

use super::CHIPS;
use super::switch::{SWITCH_WORDS, Switch};

/// Channels of a chip.
pub const CHANNELS: usize = regs::CHANNELS as usize;
/// Ticks of a PWM period.
const PERIOD: u16 = 4096;
/// Widths of a chip's pulses by channel, ticks.
pub type Widths = [u16; CHANNELS];
/// MODE1 to LED15_OFF_H.
const REGISTERS: usize = regs::LED15_OFF_H as usize + 1;
/// Eight bytes at a time, a chip with its address, pointer and PRE_SCALE.
const CHIP_WORDS: usize = (REGISTERS + 3).div_ceil(8);
/// The chips in words, after the count of changes and the time of the last one.
const CHIP_END: usize = 2 + CHIPS * CHIP_WORDS;
/// A state in words: the count of changes, the time of the last one, the chips, the switch.
pub const WORDS: usize = CHIP_END + SWITCH_WORDS;
/// Rows of what an adapter drives: the widths of each chip's pulses, and last the levels of motors.
pub const ROWS: usize = CHIPS + 1;
/// All rows in words.
pub const WIDTH_WORDS: usize = ROWS * CHANNELS / 4;

/// A chip.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Chip {
    /// Its own address; zero where there is no chip.
    pub address: u8,
    pointer: u8,
    prescale: u8,
    registers: [u8; REGISTERS],
}

impl Chip {
    /// A chip of this address that has just got its supply: asleep, every output full off.
    pub fn new(address: u8) -> Self {
        let mut registers = [0; REGISTERS];
        registers[usize::from(regs::MODE1)] = mode1::RESET;
        registers[usize::from(regs::MODE2)] = regs::mode2::RESET;
        let subaddresses = usize::from(regs::SUBADR1)..=usize::from(regs::ALLCALLADR);
        registers[subaddresses].copy_from_slice(&regs::SUBADR_RESET);
        for channel in 0..regs::CHANNELS {
            registers[usize::from(regs::led(channel)) + 3] = regs::FULL;
        }
        Self {
            address,
            pointer: 0,
            prescale: regs::PRE_SCALE_RESET,
            registers,
        }
    }

    fn mode1(&self) -> u8 {
        self.registers[usize::from(regs::MODE1)]
    }

    /// Whether it answers to an address.
    pub fn answers(&self, address: u8) -> bool {
        let all = self.registers[usize::from(regs::ALLCALLADR)] >> 1;
        let hears_all = self.mode1() & mode1::ALLCALL != 0;
        self.address != 0 && (address == self.address || hears_all && address == all)
    }

    /// The width of each channel's pulses, ticks: zero for one that is off and while the chip sleeps, a whole period for one that
    /// is full on.
    pub fn widths(&self) -> Widths {
        if self.address == 0 || self.mode1() & mode1::SLEEP != 0 {
            return [0; CHANNELS];
        }
        std::array::from_fn(|channel| {
            let first = usize::from(regs::led(channel as u8));
            let [on_l, on_h, off_l, off_h] = [0, 1, 2, 3].map(|n| self.registers[first + n]);
            let ticks = |low, high| u16::from_le_bytes([low, high & 0x0F]);
            match (off_h & regs::FULL != 0, on_h & regs::FULL != 0) {
                (true, _) => 0,
                (_, true) => PERIOD,
                _ => ticks(off_l, off_h).wrapping_sub(ticks(on_l, on_h)) % PERIOD,
            }
        })
    }

    /// A message to it: a register's address, and bytes from there on.
    pub fn write(&mut self, bytes: &[u8]) {
        let Some((&first, values)) = bytes.split_first() else {
            return;
        };
        self.pointer = first;
        for &value in values {
            self.set(value);
            self.step();
        }
    }

    /// A message from it.
    pub fn read(&mut self, bytes: &mut [u8]) {
        for byte in bytes {
            *byte = match self.pointer {
                regs::PRE_SCALE => self.prescale,
                // What is written to all outputs at once reads as zero.
                register => self.register(register).map_or(0, |r| *r),
            };
            self.step();
        }
    }

    fn register(&mut self, register: u8) -> Option<&mut u8> {
        self.registers.get_mut(usize::from(register))
    }

    fn set(&mut self, value: u8) {
        let sticky = self.mode1() & mode1::EXTCLK;
        match self.pointer {
            regs::MODE1 => self.registers[0] = value & !mode1::RESTART | sticky,
            regs::PRE_SCALE if self.mode1() & mode1::SLEEP != 0 => self.prescale = value.max(3),
            regs::ALL_LED_ON_L..=regs::ALL_LED_OFF_H => {
                let offset = usize::from(self.pointer - regs::ALL_LED_ON_L);
                for channel in 0..regs::CHANNELS {
                    self.registers[usize::from(regs::led(channel)) + offset] = value;
                }
            }
            other => {
                if let Some(register) = self.register(other) {
                    *register = value;
                }
            }
        }
    }

    fn step(&mut self) {
        if self.mode1() & mode1::AI != 0 {
            self.pointer = match self.pointer {
                regs::LED15_OFF_H => 0,
                other => other.wrapping_add(1),
            };
        }
    }
}

/// The chips of an adapter at one time, and when what they drive changed last.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct State {
    /// How often what is driven has changed.
    pub changes: u64,
    /// CLOCK_MONOTONIC_RAW of the last change, nanoseconds.
    pub at_ns: u64,
    /// The chips.
    pub chips: [Chip; CHIPS],
    /// The switch before drivers of motors, if there is one.
    pub switch: Switch,
}

impl State {
    /// Chips that have just got their supply.
    pub fn new(addresses: &[u8]) -> Self {
        let address = |n: usize| addresses.get(n).copied().unwrap_or(0);
        Self {
            changes: 0,
            at_ns: 0,
            chips: std::array::from_fn(|n| Chip::new(address(n))),
            switch: Switch::NONE,
        }
    }

    /// The widths of the pulses that the chips drive, and last the levels of motors.
    pub fn widths(&self) -> [Widths; ROWS] {
        std::array::from_fn(|row| {
            let chip = self.chips.get(row);
            chip.map_or_else(|| self.switch.levels(), Chip::widths)
        })
    }

    /// Whether any channel makes pulses, or any motor is driven.
    pub fn is_on(&self) -> bool {
        self.widths().as_flattened().iter().any(|width| *width != 0)
    }

    pub(super) fn words(&self) -> [u64; WORDS] {
        let mut words = [0; WORDS];
        words[0] = self.changes;
        words[1] = self.at_ns;
        for (chip, place) in self
            .chips
            .iter()
            .zip(words[2..CHIP_END].chunks_exact_mut(CHIP_WORDS))
        {
            let mut bytes = [0; CHIP_WORDS * 8];
            bytes[..3].copy_from_slice(&[chip.address, chip.pointer, chip.prescale]);
            bytes[3..3 + REGISTERS].copy_from_slice(&chip.registers);
            for (word, bytes) in place.iter_mut().zip(bytes.as_chunks::<8>().0) {
                *word = u64::from_ne_bytes(*bytes);
            }
        }
        words[CHIP_END..].copy_from_slice(&self.switch.words());
        words
    }

    pub(super) fn of_words(words: &[u64; WORDS]) -> Self {
        let mut state = Self::new(&[]);
        state.changes = words[0];
        state.at_ns = words[1];
        for (chip, place) in state
            .chips
            .iter_mut()
            .zip(words[2..CHIP_END].chunks_exact(CHIP_WORDS))
        {
            let mut bytes = [0; CHIP_WORDS * 8];
            for (bytes, word) in bytes.as_chunks_mut::<8>().0.iter_mut().zip(place) {
                *bytes = word.to_ne_bytes();
            }
            [chip.address, chip.pointer, chip.prescale] = [bytes[0], bytes[1], bytes[2]];
            chip.registers.copy_from_slice(&bytes[3..3 + REGISTERS]);
        }
        state.switch = Switch::of_words(&words[CHIP_END..]);
        state
    }
}

/// Widths of pulses, in words.
pub fn packed(widths: &[Widths; ROWS]) -> [u64; WIDTH_WORDS] {
    let widths = widths.as_flattened().as_chunks::<4>().0;
    std::array::from_fn(|n| {
        widths[n]
            .iter()
            .rev()
            .fold(0, |all, w| all << 16 | u64::from(*w))
    })
}

/// The widths that [`packed`] made words of.
pub fn unpacked(words: &[u64; WIDTH_WORDS]) -> [Widths; ROWS] {
    std::array::from_fn(|chip| {
        std::array::from_fn(|channel| {
            let place = chip * CHANNELS + channel;
            (words[place / 4] >> (16 * (place % 4))) as u16
        })
    })
}
