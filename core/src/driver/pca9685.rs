//! The PCA9685 driver: one or several boards on one I2C bus (NXP data sheet rev. 4).
//!
//! Every update is one contiguous auto-increment write of the channels that change, ended by one STOP:
//! register-at-a-time writes expose mixed (ON, OFF) pairs for a period, and one such period can be 90 %
//! duty. A channel that is off carries the full-off bit, and nothing ever sets full on.

use alloc::boxed::Box;
use core::fmt;

use embedded_hal::i2c::{Error as I2cError, ErrorKind, I2c, NoAcknowledgeSource};

use super::{Actuators, UnitFault};
use crate::codec::pca9685::{self as regs, mode1, mode2};
use crate::guard::{Guarded, Setting};
use crate::units::{Board, Duration, Instant, Prescale};

/// What went wrong, on which board, and whether trying again makes sense.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DriverError {
    /// No board answers at the address of this index.
    NoSuchBoard(Board),
    /// The bus reported this while talking to a board.
    Bus(Board, ErrorKind),
    /// The board did not read back what was written: register, expected, found.
    Readback(Board, u8, u8, u8),
    /// The driver unit that has the boards cannot be driven.
    Unit(UnitFault),
}

impl DriverError {
    /// Whether the same call may succeed if made again: arbitration lost, a busy or disturbed bus.
    pub const fn is_transient(&self) -> bool {
        matches!(
            self,
            Self::Bus(
                _,
                ErrorKind::ArbitrationLoss | ErrorKind::Bus | ErrorKind::Overrun
            )
        )
    }
}

impl fmt::Display for DriverError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NoSuchBoard(b) => write!(f, "board {}: not one of this bench's boards", b.0),
            Self::Bus(b, kind) => {
                let hint = match kind {
                    ErrorKind::NoAcknowledge(NoAcknowledgeSource::Address) => {
                        ": no chip answers at its address; check wiring, power and the address straps"
                    }
                    ErrorKind::NoAcknowledge(_) => ": the chip refused a byte",
                    ErrorKind::ArbitrationLoss => ": another master is on this bus",
                    _ => "",
                };
                write!(f, "board {}: I2C {kind:?}{hint}", b.0)
            }
            Self::Readback(b, regs::MODE1, want, got) if got & !want & mode1::EXTCLK != 0 => {
                write!(
                    f,
                    "board {}: register 0x00 reads {got:#04x}, expected {want:#04x}: the chip counts by its EXTCLK pin until its next power-up; switch it off and on, or state drive.clock",
                    b.0
                )
            }
            Self::Readback(b, reg, want, got) => write!(
                f,
                "board {}: register {reg:#04x} reads {got:#04x}, expected {want:#04x}: brown-out, or another program on the bus",
                b.0
            ),
            Self::Unit(fault) => fault.fmt(f),
        }
    }
}

impl core::error::Error for DriverError {}

/// Times a transfer is tried before a transient error counts.
const ATTEMPTS: u32 = 3;

/// One board: its address and what its channels were last told. `None` after anything that may have
/// left them otherwise, so that the next update writes them whatever it says.
#[derive(Clone, Debug)]
pub(super) struct BoardState {
    address: u8,
    shadow: [Option<[u8; 4]>; 16],
}

/// What updates came to on the bus.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Traffic {
    /// Updates sent, one write each.
    pub writes: u64,
    /// Updates that would have changed no register, and were not sent.
    pub unchanged_updates: u64,
    /// Channels written.
    pub channels: u64,
    /// Channels of updates that already held what they should, and were not written.
    pub unchanged_channels: u64,
}

/// Up to 16 PCA9685 boards on one bus.
#[derive(Debug)]
pub struct Pca9685Bank<I> {
    i2c: I,
    pub(super) boards: Box<[BoardState]>,
    /// Number of the first board: a bench with several buses counts its boards through.
    first: u8,
    prescale: Prescale,
    retries: u64,
    traffic: Traffic,
}

impl<I: I2c> Pca9685Bank<I> {
    /// A bank over the boards' 7-bit addresses; nothing is sent yet.
    pub fn new(i2c: I, addresses: &[u8], prescale: Prescale) -> Self {
        let board = |&address: &u8| BoardState {
            address,
            shadow: [None; 16],
        };
        Self {
            i2c,
            boards: addresses.iter().map(board).collect(),
            first: 0,
            prescale,
            retries: 0,
            traffic: Traffic::default(),
        }
    }

    /// The same with its boards numbered from `first`, where another bus carries those before.
    #[must_use]
    pub fn numbered_from(mut self, first: u8) -> Self {
        self.first = first;
        self
    }

    /// The boards' numbers.
    pub fn numbers(&self) -> impl Iterator<Item = Board> + use<I> {
        let count = self.boards.len() as u8; // at most 63 addresses
        (self.first..self.first.saturating_add(count)).map(Board)
    }

    /// Everything off and verified, then each board configured: asleep, on its external clock if it has one, PRE_SCALE,
    /// totem-pole outputs that change on STOP and are low while OE is high, awake with auto-increment and all-call.
    /// Returns when the oscillators run: 500 us after `now` and the bus time (7.3.1.1); the first update must
    /// not come earlier.
    ///
    /// # Errors
    /// [`DriverError`] of the first board that does not answer or does not read back.
    pub fn start(&mut self, now: Instant) -> Result<Instant, DriverError> {
        self.switch_off()?;
        for board in self.numbers() {
            self.expect(board, regs::LED0_ON_L + 3, regs::FULL)?;
            let asleep = mode1::SLEEP | mode1::AI | mode1::ALLCALL;
            self.write(board, &[regs::MODE1, asleep, mode2::OUTDRV])?;
            if self.awake() & mode1::EXTCLK != 0 {
                // The switch is made by a write while asleep, with both bits set (7.3.1).
                self.write(board, &[regs::MODE1, asleep | mode1::EXTCLK])?;
            }
            self.write(board, &[regs::PRE_SCALE, self.prescale.get()])?;
            self.expect(board, regs::PRE_SCALE, self.prescale.get())?;
            self.write(board, &[regs::MODE1, self.awake()])?;
            self.expect(board, regs::MODE1, self.awake())?;
        }
        Ok(now + Duration::from_micros(regs::WAKE_US))
    }

    /// MODE1 of a board that was started.
    const fn awake(&self) -> u8 {
        let external = self.prescale.clock().tolerance_ppm().is_some();
        let clock = if external { mode1::EXTCLK } else { 0 };
        mode1::AI | mode1::ALLCALL | clock
    }

    /// Transfers made again after a transient error.
    pub const fn retries(&self) -> u64 {
        self.retries
    }

    /// What updates came to on the bus so far.
    pub const fn traffic(&self) -> Traffic {
        self.traffic
    }

    /// Whether every board still is as [`Self::start`] left it: a chip that fell back to its reset values
    /// sleeps, and nothing on the bus says so.
    ///
    /// # Errors
    /// [`DriverError`] of the first board that does not answer or does not read back.
    pub fn verify(&mut self) -> Result<(), DriverError> {
        for board in self.numbers() {
            self.expect(board, regs::MODE1, self.awake())?;
        }
        Ok(())
    }

    /// The bus, for an owner that must look at it.
    pub fn bus(&self) -> &I {
        &self.i2c
    }

    /// Where a board of this number stands in the bank; past its end for another's.
    fn index(&self, board: Board) -> usize {
        usize::from(board.0).wrapping_sub(self.first.into())
    }

    pub(super) fn address(&self, board: Board) -> Result<u8, DriverError> {
        let state = self.boards.get(self.index(board));
        state
            .map(|b| b.address)
            .ok_or(DriverError::NoSuchBoard(board))
    }

    fn write(&mut self, board: Board, bytes: &[u8]) -> Result<(), DriverError> {
        let address = self.address(board)?;
        self.patiently(board, |i2c| i2c.write(address, bytes))
    }

    /// Makes a transfer, and makes it again from its first byte after a transient error: what part of it
    /// arrived is written over by the same values, so an update is never torn.
    pub(super) fn patiently(
        &mut self,
        board: Board,
        mut transfer: impl FnMut(&mut I) -> Result<(), I::Error>,
    ) -> Result<(), DriverError> {
        let mut attempt = 1;
        loop {
            let Err(error) = transfer(&mut self.i2c) else {
                return Ok(());
            };
            let error = DriverError::Bus(board, error.kind());
            if attempt == ATTEMPTS || !error.is_transient() {
                return Err(error);
            }
            attempt += 1;
            self.retries += 1;
        }
    }

    fn expect(&mut self, board: Board, register: u8, want: u8) -> Result<(), DriverError> {
        let address = self.address(board)?;
        let mut got = [0];
        self.patiently(board, |i2c| i2c.write_read(address, &[register], &mut got))?;
        if got[0] == want {
            Ok(())
        } else {
            Err(DriverError::Readback(board, register, want, got[0]))
        }
    }

    /// All-call full off, then each board by its own address, so that one that does not listen to
    /// all-call is off too. Every board is tried whatever the others answer; the first error of an own
    /// address is returned.
    fn switch_off(&mut self) -> Result<(), DriverError> {
        const OFF: [u8; 2] = [regs::ALL_LED_OFF_H, regs::FULL];
        // No chip listens to all-call if every ALLCALL bit is clear: the writes below decide.
        let _ = self.i2c.write(regs::ALLCALL_ADDRESS, &OFF);
        let mut result = Ok(());
        self.boards.iter_mut().for_each(|b| b.shadow = [None; 16]);
        for board in self.numbers() {
            let written = self.write(board, &OFF);
            result = result.and(written);
        }
        result
    }
}

/// The four registers of a channel.
fn registers(setting: Setting) -> [u8; 4] {
    let [on_l, on_h] = setting.on.min(4095).to_le_bytes();
    if setting.off <= setting.on {
        return [on_l, on_h, on_l, on_h | regs::FULL];
    }
    // OFF = 4096 has no register value: counting wraps to 0, which would be a wrapped pulse.
    let [off_l, off_h] = setting.off.min(4095).to_le_bytes();
    [on_l, on_h, off_l, off_h]
}

impl<I: I2c> Actuators for Pca9685Bank<I> {
    type Error = DriverError;

    fn apply(&mut self, update: &Guarded) -> Result<(), DriverError> {
        let board = update.board();
        let index = self.index(board);
        let Some(state) = self.boards.get_mut(index) else {
            return Err(DriverError::NoSuchBoard(board));
        };
        // What every channel shall hold, and the range of those that do not hold it yet.
        let mut wanted = state.shadow;
        for (slot, setting) in wanted.iter_mut().zip(update.channels()) {
            if let Some(setting) = setting {
                *slot = Some(registers(*setting));
            }
        }
        let differs = |c: &usize| wanted[*c] != state.shadow[*c];
        let asked = update.channels().iter().flatten().count() as u64;
        let (Some(first), Some(last)) = ((0..16).find(differs), (0..16).rev().find(differs)) else {
            self.traffic.unchanged_updates += 1;
            self.traffic.unchanged_channels += asked;
            return Ok(());
        };
        let changed = (first..=last).filter(differs).count() as u64;
        self.traffic.writes += 1;
        self.traffic.channels += changed;
        self.traffic.unchanged_channels += asked.saturating_sub(changed);
        // One write, so unknown channels in between are written too: off, as they were left.
        const OFF: [u8; 4] = [0, 0, 0, regs::FULL];
        let mut bytes = [0; 65];
        bytes[0] = regs::led(first as u8);
        for (quad, channel) in bytes[1..].chunks_exact_mut(4).zip(first..=last) {
            quad.copy_from_slice(wanted[channel].get_or_insert(OFF));
        }
        let length = 1 + 4 * (last - first + 1);
        let (address, old) = (state.address, state.shadow);
        state.shadow = wanted;
        let written = self.patiently(board, |i2c| i2c.write(address, &bytes[..length]));
        written.inspect_err(|_| {
            // Part of it may have arrived: nothing in this range is known any more.
            let shadow = &mut self.boards[index].shadow;
            *shadow = old;
            shadow[first..=last].fill(None);
        })
    }

    fn all_off(&mut self) -> Result<(), DriverError> {
        self.switch_off()
    }
}
