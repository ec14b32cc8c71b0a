//! The PCA9685 driver: one or several boards on one I2C bus (NXP data sheet rev. 4).
//!
//! Every update is one contiguous auto-increment write of the channels that change, ended by one STOP:
//! register-at-a-time writes expose mixed (ON, OFF) pairs for a period, and one such period can be 90 %
//! duty. A channel that is off carries the full-off bit, and nothing ever sets full on.

use alloc::boxed::Box;

use embedded_hal::i2c::{Error as I2cError, ErrorKind, I2c, NoAcknowledgeSource};

use super::dac7578::Converter;
use super::{Actuators, AudioFault, HapticFault, UnitFault, WHOLE};
use crate::codec::pca9685::{self as regs, mode1, mode2};
use crate::guard::{Guarded, Setting};
use crate::units::{Board, Duration, Instant, Prescale};

/// Error of a transfer, with its board; [`DriverError::is_transient`] tells whether a repeat makes sense.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum DriverError {
    /// No board answers at the address of this index.
    #[error("board {}: not one of this bench's boards", .0.0)]
    NoSuchBoard(Board),
    /// The bus reported this while talking to a board.
    #[error("board {board}: I2C {1:?}{hint}", board = .0.0, hint = hint(*.1))]
    Bus(Board, ErrorKind),
    /// The board did not read back what was written: register, expected, found.
    #[error("board {board}: register {1:#04x} reads {3:#04x}, expected {2:#04x}: {why}", board = .0.0, why = why_misread(*.1, *.2, *.3))]
    Readback(Board, u8, u8, u8),
    /// An output's converter does not hold the code that was written: output, expected, found.
    #[error("board {board}: the converter of output {1} reads {3}, expected {2}: brown-out, a defect, or another program on the bus", board = .0.0)]
    Current(Board, u8, u16, u16),
    /// An output that shall have a current set has no converter.
    #[error("board {board}: output {1} has no converter, expected one of outputs 0 to 7 of a board with a DAC7578", board = .0.0)]
    NoConverter(Board, u8),
    /// The driver unit that has the boards cannot be driven.
    #[error(transparent)]
    Unit(UnitFault),
    /// A haptic driver cannot be driven.
    #[error(transparent)]
    Haptic(HapticFault),
    /// A sound card cannot be driven.
    #[error(transparent)]
    Audio(AudioFault),
}

impl DriverError {
    /// Tells whether the same call may succeed if made again: arbitration lost, a busy or disturbed bus.
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

/// The end of the message about a bus that failed: where to look.
const fn hint(kind: ErrorKind) -> &'static str {
    match kind {
        ErrorKind::NoAcknowledge(NoAcknowledgeSource::Address) => {
            ": no chip answers at its address; check wiring, power and the address straps"
        }
        ErrorKind::NoAcknowledge(_) => ": the chip refused a byte",
        ErrorKind::ArbitrationLoss => ": another master is on this bus",
        _ => "",
    }
}

/// The likely reason why a register does not read back what was written.
const fn why_misread(register: u8, want: u8, got: u8) -> &'static str {
    if register == regs::MODE1 && got & !want & mode1::EXTCLK != 0 {
        "the chip counts by its EXTCLK pin until its next power-up; switch it off and on, or state drive.clock"
    } else {
        "brown-out, or another program on the bus"
    }
}

/// Times a transfer is tried before a transient error counts.
const ATTEMPTS: u32 = 3;

/// One board: its address, and the registers that its channels were last told. `None` stands after anything that may
/// have left them otherwise, so that the next update writes them whatever it says.
#[derive(Clone, Debug)]
pub(super) struct BoardState {
    address: u8,
    /// Channels that are this driver's, a bit each.
    own: u16,
    shadow: [Option<[u8; 4]>; 16],
    /// Converter that sets the currents of the board's outputs; `None` for amplifiers with a current of their own.
    pub(super) converter: Option<Converter>,
}

/// Traffic of updates on the bus.
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

impl Traffic {
    /// Adds the traffic of another driver.
    pub fn add(&mut self, other: &Self) {
        self.writes += other.writes;
        self.unchanged_updates += other.unchanged_updates;
        self.channels += other.channels;
        self.unchanged_channels += other.unchanged_channels;
    }
}

/// Up to 16 PCA9685 boards on one bus.
#[derive(Debug)]
pub struct Pca9685Bank<I> {
    i2c: I,
    pub(super) boards: Box<[BoardState]>,
    /// Number of the first board: a bench with several buses counts its boards through.
    first: u8,
    prescale: Prescale,
    /// `true` where other drivers use the bus too.
    shared: bool,
    retries: u64,
    traffic: Traffic,
}

/// The four registers of a channel that is off.
const OFF: [u8; 4] = [0, 0, 0, regs::FULL];
/// The write that switches a whole board off.
const ALL_OFF: [u8; 2] = [regs::ALL_LED_OFF_H, regs::FULL];

impl<I: I2c> Pca9685Bank<I> {
    /// A bank over the boards' 7-bit addresses; nothing is sent yet.
    pub fn new(i2c: I, addresses: &[u8], prescale: Prescale) -> Self {
        let board = |&address: &u8| BoardState {
            address,
            own: WHOLE,
            shadow: [None; 16],
            converter: None,
        };
        Self {
            i2c,
            boards: addresses.iter().map(board).collect(),
            first: 0,
            prescale,
            shared: false,
            retries: 0,
            traffic: Traffic::default(),
        }
    }

    /// Returns the bank with its boards numbered from `first`, where another bus carries those before.
    #[must_use]
    pub(super) fn numbered_from(mut self, first: u8) -> Self {
        self.first = first;
        self
    }

    /// Returns the bank for a bus that other drivers use too. `channels` has a bit for each channel of this driver,
    /// board by board. The bank then sends nothing by all-call and writes no other channel. It configures a shared
    /// board only where that has lost its settings.
    #[must_use]
    pub fn sharing(mut self, channels: &[u16]) -> Self {
        self.shared = true;
        for (state, own) in self.boards.iter_mut().zip(channels) {
            state.own = *own;
        }
        self
    }

    /// The boards' numbers.
    pub fn numbers(&self) -> impl Iterator<Item = Board> + use<I> {
        let count = self.boards.len() as u8; // at most 63 addresses
        (self.first..self.first.saturating_add(count)).map(Board)
    }

    /// Switches everything off and verifies it. Then configures each board: asleep, on its external clock if it has
    /// one, PRE_SCALE, totem-pole outputs that change on STOP and are low while OE is high, awake with auto-increment
    /// and all-call. Returns when the oscillators run: 500 us after `now` and the bus time (7.3.1.1); the first update
    /// must not come earlier.
    ///
    /// # Errors
    /// [`DriverError`] of the first board that does not answer or does not read back.
    pub fn start(&mut self, now: Instant) -> Result<Instant, DriverError> {
        self.switch_off()?;
        for board in self.numbers() {
            let own = self.own(board);
            let first = own.trailing_zeros() as u8; // below 16: a driver has a channel of each of its boards
            self.expect(board, regs::led(first) + 3, regs::FULL)?;
            if own != WHOLE {
                if self.is_started(board)? {
                    self.start_converter(board)?;
                    continue;
                }
                // What others had on it is lost as well, and they are about to find out.
                self.write(board, &ALL_OFF)?;
            }
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
            self.start_converter(board)?;
        }
        Ok(now + Duration::from_micros(regs::WAKE_US))
    }

    /// Tells whether a board has its settings, from another driver's start.
    fn is_started(&mut self, board: Board) -> Result<bool, DriverError> {
        let settings = [
            (regs::MODE1, self.awake()),
            (regs::MODE2, mode2::OUTDRV),
            (regs::PRE_SCALE, self.prescale.get()),
        ];
        for (register, want) in settings {
            match self.expect(board, register, want) {
                Err(DriverError::Readback(..)) => return Ok(false),
                other => other?,
            }
        }
        Ok(true)
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

    /// Traffic of updates on the bus so far.
    pub const fn traffic(&self) -> Traffic {
        self.traffic
    }

    /// Confirms that every board still is as [`Self::start`] left it: a chip that fell back to its reset values sleeps,
    /// and nothing on the bus says so.
    ///
    /// # Errors
    /// [`DriverError`] of the first board that does not answer or does not read back.
    pub fn verify(&mut self) -> Result<(), DriverError> {
        for board in self.numbers() {
            self.expect(board, regs::MODE1, self.awake())?;
            self.verify_converter(board)?;
        }
        Ok(())
    }

    /// The bus, for an owner that must look at it.
    pub fn bus(&self) -> &I {
        &self.i2c
    }

    /// The bus, for an owner that looks after it between two transfers.
    pub const fn bus_mut(&mut self) -> &mut I {
        &mut self.i2c
    }

    /// Index of a board in the bank; past its end for a board of another bank.
    pub(super) fn index(&self, board: Board) -> usize {
        usize::from(board.0).wrapping_sub(self.first.into())
    }

    /// The channels of a board that are this driver's, a bit each.
    pub(super) fn own(&self, board: Board) -> u16 {
        self.boards.get(self.index(board)).map_or(0, |b| b.own)
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

    /// Switches off by all-call, then each board by its own address, so that a board that does not listen to all-call
    /// is off too. On boards that others use as well it switches off the own channels alone. Every board is tried
    /// whatever the others answer; the first error of an own address is returned. Currents go to zero last: then two
    /// chips would have to fail for a wire to be heated.
    fn switch_off(&mut self) -> Result<(), DriverError> {
        if !self.shared {
            // No chip listens to all-call if every ALLCALL bit is clear: the writes below decide.
            let _ = self.i2c.write(regs::ALLCALL_ADDRESS, &ALL_OFF);
        }
        let mut result = Ok(());
        self.boards.iter_mut().for_each(|b| b.shadow = [None; 16]);
        for board in self.numbers() {
            let written = match self.own(board) {
                WHOLE => self.write(board, &ALL_OFF),
                own => self.write_off(board, own),
            };
            result = result.and(written);
        }
        for board in self.numbers() {
            let zeroed = self.zero_converter(board);
            result = result.and(zeroed);
        }
        result
    }

    /// Switches channels off, one by one: a register each, so that it works whether or not the chip counts addresses up.
    fn write_off(&mut self, board: Board, channels: u16) -> Result<(), DriverError> {
        // One that fails keeps none of the others on.
        let mut result = Ok(());
        for channel in (0..regs::CHANNELS).filter(|c| channels >> c & 1 == 1) {
            let written = self.write(board, &[regs::led(channel) + 3, regs::FULL]);
            result = result.and(written);
        }
        result
    }
}

/// Each run of neighbours among channels, a bit each.
fn runs(mut channels: u16) -> impl Iterator<Item = u16> {
    core::iter::from_fn(move || {
        let first = channels.trailing_zeros();
        let length = channels.checked_shr(first)?.trailing_ones();
        let run = ((1_u32 << length) - 1) << first;
        channels &= !(run as u16);
        Some(run as u16)
    })
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
        self.set_currents(update)?;
        let Some(state) = self.boards.get(index) else {
            return Err(DriverError::NoSuchBoard(board));
        };
        let (address, own, held) = (state.address, state.own, state.shadow);
        // What every channel shall hold, and those that do not hold it yet.
        let mut wanted = held;
        for (slot, setting) in wanted.iter_mut().zip(update.channels()) {
            if let Some(setting) = setting {
                *slot = Some(registers(*setting));
            }
        }
        let differing = (0..16).filter(|c| wanted[*c] != held[*c]);
        let differing = differing.fold(0_u16, |all, channel| all | 1 << channel);
        let asked = update.channels().iter().flatten().count() as u64;
        if differing == 0 {
            self.traffic.unchanged_updates += 1;
            self.traffic.unchanged_channels += asked;
            return Ok(());
        }
        let changed = u64::from(differing.count_ones());
        self.traffic.channels += changed;
        self.traffic.unchanged_channels += asked.saturating_sub(changed);
        // One write for neighbours, so unknown channels in between are written too: off, as they were left.
        for run in runs(own).filter(|run| run & differing != 0) {
            let written = differing & run;
            let first = written.trailing_zeros() as usize;
            let last = written.ilog2() as usize;
            let mut bytes = [0; 65];
            bytes[0] = regs::led(first as u8);
            for (quad, channel) in bytes[1..].chunks_exact_mut(4).zip(first..=last) {
                quad.copy_from_slice(wanted[channel].get_or_insert(OFF));
            }
            let length = 1 + 4 * (last - first + 1);
            // Part of it may arrive: nothing in this range is known until all of it has.
            self.boards[index].shadow[first..=last].fill(None);
            self.traffic.writes += 1;
            self.patiently(board, |i2c| i2c.write(address, &bytes[..length]))?;
            self.boards[index].shadow[first..=last].copy_from_slice(&wanted[first..=last]);
        }
        Ok(())
    }

    fn all_off(&mut self) -> Result<(), DriverError> {
        self.switch_off()
    }
}
