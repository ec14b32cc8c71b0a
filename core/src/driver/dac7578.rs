//! The DAC7578 beside a board: it sets the currents of that board's outputs 0 to 7 (TI data sheet SBAS496A).
//!
//! A code is written once and its DAC register read back before every pulse, also where the code stays the same: what a
//! disturbance does to a converter is found before the wire is on again.

use embedded_hal::i2c::I2c;

use super::{DriverError, Pca9685Bank, WHOLE};
use crate::codec::dac7578 as regs;
use crate::guard::Guarded;
use crate::units::{Board, Milliamps};

/// The converter of one board.
#[derive(Clone, Debug)]
pub(super) struct Converter {
    address: u8,
    /// Current at its largest code.
    full_scale: Milliamps,
    /// Codes that were written and have read back; `None` after anything that may have left them otherwise.
    held: [Option<u16>; regs::CHANNELS as usize],
}

impl Converter {
    /// The code of a current.
    fn code(&self, current: Milliamps) -> u16 {
        regs::code_of(current.0, self.full_scale.0)
    }
}

impl<I: I2c> Pca9685Bank<I> {
    /// Returns the bank with a DAC7578 for each board, by 7-bit address: output n
    /// sets the current of channel n, `full_scale` at its largest code. On a
    /// board that other drivers use too it touches the bank's own channels alone.
    #[must_use]
    pub fn with_converters(mut self, addresses: &[u8], full_scale: Milliamps) -> Self {
        for (state, address) in self.boards.iter_mut().zip(addresses) {
            state.converter = Some(Converter {
                address: *address,
                full_scale,
                held: [None; regs::CHANNELS as usize],
            });
        }
        self
    }

    /// Sets a board's converter up and reads it back: no channel waits for the LDAC pin, all are on and at zero.
    pub(super) fn start_converter(&mut self, board: Board) -> Result<(), DriverError> {
        self.command(board, regs::LDAC, 0, regs::NO_PIN)?;
        self.command(board, regs::POWER, 0, regs::ALL_ON)?;
        self.zero_converter(board)?;
        self.confirm_zero(board)
    }

    /// Outputs of a board's converter that are this driver's.
    fn own_outputs(&self, board: Board) -> impl Iterator<Item = u8> + use<I> {
        let own = self.converter(board).map_or(0, |_| self.own(board));
        (0..regs::CHANNELS).filter(move |channel| own >> channel & 1 == 1)
    }

    /// Confirms that every code that was read back still is there.
    pub(super) fn verify_converter(&mut self, board: Board) -> Result<(), DriverError> {
        let held = self.converter(board).map_or([None; 8], |c| c.held);
        for (channel, code) in (0..).zip(held) {
            if let Some(code) = code {
                self.confirm_code(board, channel, code)?;
            }
        }
        Ok(())
    }

    /// Reads back that no current of a board is set; a board without a converter has none.
    ///
    /// # Errors
    /// A current that is not zero, or a converter that does not answer.
    pub fn confirm_zero(&mut self, board: Board) -> Result<(), DriverError> {
        for channel in self.own_outputs(board) {
            self.confirm_code(board, channel, 0)?;
        }
        Ok(())
    }

    /// Sets all currents of a board that are this driver's to zero; they are read back before they are used.
    pub(super) fn zero_converter(&mut self, board: Board) -> Result<(), DriverError> {
        if let Some(converter) = self.converter_mut(board) {
            converter.held = [None; regs::CHANNELS as usize];
        }
        if self.own(board) == WHOLE {
            return self.command(board, regs::WRITE_UPDATE, regs::ALL, 0);
        }
        // One that fails keeps none of the others up.
        let mut result = Ok(());
        for channel in self.own_outputs(board) {
            let zeroed = self.command(board, regs::WRITE_UPDATE, channel, 0);
            result = result.and(zeroed);
        }
        result
    }

    /// Sets the current of every channel that an update switches on, and reads it back.
    pub(super) fn set_currents(&mut self, update: &Guarded) -> Result<(), DriverError> {
        let board = update.board();
        if self.converter(board).is_none() {
            return Ok(());
        }
        for channel in 0..16 {
            let Some(current) = update.current(channel) else {
                continue;
            };
            let Some(converter) = self.converter_mut(board) else {
                continue;
            };
            let code = converter.code(current);
            let Some(held) = converter.held.get_mut(usize::from(channel)) else {
                return Err(DriverError::NoConverter(board, channel));
            };
            if *held != Some(code) {
                *held = None;
                self.command(board, regs::WRITE_UPDATE, channel, regs::data(code))?;
            }
            self.confirm_code(board, channel, code)?;
        }
        Ok(())
    }

    /// Reads a DAC register and compares it; from then on the code counts as held.
    fn confirm_code(&mut self, board: Board, channel: u8, want: u16) -> Result<(), DriverError> {
        let Some(address) = self.converter(board).map(|c| c.address) else {
            return Ok(());
        };
        let mut bytes = [0; 2];
        let ask = [regs::UPDATE | channel];
        self.patiently(board, |i2c| i2c.write_read(address, &ask, &mut bytes))?;
        let got = regs::code(bytes);
        let held = (got == want).then_some(want);
        let converter = self.converter_mut(board);
        if let Some(slot) = converter.and_then(|c| c.held.get_mut(usize::from(channel))) {
            *slot = held;
        }
        held.map(|_| ())
            .ok_or(DriverError::Current(board, channel, want, got))
    }

    /// Sends a command to a board's converter, if it has one.
    fn command(
        &mut self,
        board: Board,
        command: u8,
        access: u8,
        data: u16,
    ) -> Result<(), DriverError> {
        let Some(address) = self.converter(board).map(|c| c.address) else {
            return Ok(());
        };
        let bytes = regs::frame(command, access, data);
        self.patiently(board, |i2c| i2c.write(address, &bytes))
    }

    fn converter(&self, board: Board) -> Option<&Converter> {
        self.boards.get(self.index(board))?.converter.as_ref()
    }

    fn converter_mut(&mut self, board: Board) -> Option<&mut Converter> {
        let index = self.index(board);
        self.boards.get_mut(index)?.converter.as_mut()
    }
}
