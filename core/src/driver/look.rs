//! Registers of a chip as it was found: before anything is written to it, and after everything was switched off.

use embedded_hal::i2c::I2c;

use super::{DriverError, Pca9685Bank};
use crate::codec::pca9685::{self as regs, mode1};
use crate::units::Board;

/// Registers of a chip as they were read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Seen {
    /// MODE1.
    pub mode1: u8,
    /// MODE2.
    pub mode2: u8,
    /// PRE_SCALE.
    pub prescale: u8,
    /// Channels whose registers make a pulse, a bit each.
    pub loaded: u16,
    /// Channels whose registers made a pulse until the board was switched off whole, a bit each.
    pub stopped: u16,
}

impl Seen {
    /// Channels that drive their output now: none while the chip sleeps.
    pub const fn driving(&self) -> u16 {
        if self.mode1 & mode1::SLEEP == 0 {
            self.loaded
        } else {
            0
        }
    }

    /// Channels that drove their output until the board was switched off whole.
    pub const fn drove(&self) -> u16 {
        if self.mode1 & mode1::SLEEP == 0 {
            self.stopped
        } else {
            0
        }
    }
}

/// Tells whether a channel's four registers make a pulse (7.3.3): full off wins over all, full on over the rest.
const fn makes_a_pulse([on_l, on_h, off_l, off_h]: [u8; 4]) -> bool {
    if off_h & regs::FULL != 0 {
        return false;
    }
    on_h & regs::FULL != 0 || on_l != off_l || (on_h ^ off_h) & 0x0F != 0
}

/// Tells whether a channel's four registers made a pulse before an all-off took the upper half of its OFF count. A
/// pulse of a multiple of 256 ticks, longer than any that the guard passes at 200 Hz, leaves no trace.
const fn made_a_pulse([on_l, on_h, off_l, off_h]: [u8; 4]) -> bool {
    off_h == regs::FULL && (on_h & regs::FULL != 0 || on_l != off_l)
}

impl<I: I2c> Pca9685Bank<I> {
    /// Takes the traces of pulses off a board that is off, so that a later look does not find them again. Full off stays.
    ///
    /// # Errors
    /// [`DriverError`] when it does not answer.
    pub fn forget_pulses(&mut self, board: Board) -> Result<(), DriverError> {
        let address = self.address(board)?;
        // One register at a time: the chip may have been left without auto-increment.
        for register in [
            regs::ALL_LED_ON_L,
            regs::ALL_LED_ON_L + 1,
            regs::ALL_LED_ON_L + 2,
        ] {
            self.patiently(board, |i2c| i2c.write(address, &[register, 0]))?;
        }
        Ok(())
    }

    /// Reads a board, whatever state it is in, and changes nothing.
    ///
    /// # Errors
    /// [`DriverError`] when it does not answer.
    pub fn look(&mut self, board: Board) -> Result<Seen, DriverError> {
        let mode1 = self.read(board, regs::MODE1)?;
        let mut seen = Seen {
            mode1,
            mode2: self.read(board, regs::MODE2)?,
            prescale: self.read(board, regs::PRE_SCALE)?,
            loaded: 0,
            stopped: 0,
        };
        let mut all = [0; 4 * regs::CHANNELS as usize];
        if mode1 & mode1::AI != 0 {
            let address = self.address(board)?;
            self.patiently(board, |i2c| {
                i2c.write_read(address, &[regs::LED0_ON_L], &mut all)
            })?;
        } else {
            // The pointer stays where it is: one register at a time.
            for (register, byte) in (regs::LED0_ON_L..).zip(&mut all) {
                *byte = self.read(board, register)?;
            }
        }
        for (channel, quad) in all.as_chunks::<4>().0.iter().enumerate() {
            seen.loaded |= u16::from(makes_a_pulse(*quad)) << channel;
            seen.stopped |= u16::from(made_a_pulse(*quad)) << channel;
        }
        Ok(seen)
    }

    fn read(&mut self, board: Board, register: u8) -> Result<u8, DriverError> {
        let address = self.address(board)?;
        let mut byte = [0];
        self.patiently(board, |i2c| i2c.write_read(address, &[register], &mut byte))?;
        Ok(byte[0])
    }
}

#[cfg(test)]
#[path = "look_tests.rs"]
mod tests;
