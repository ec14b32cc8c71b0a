//! A writer of registers for runs that the guard only observes. It writes to the emulated bus and to no other.

use embedded_hal::i2c::{Error as _, I2c};
use palpate_core::codec::dac7578;
use palpate_core::codec::pca9685::{self as regs, CHANNELS, FULL};
use palpate_core::driver::{Actuators, DriverError, Traffic};
use palpate_core::guard::{Observed, Setting};
use palpate_core::units::{Board, Milliamps};

use super::i2c::I2cHandle;
use super::i2c::fault::Shared;

/// Writes what a run asked for as bytes. The boards are started and looked after by their driver. A transfer that fails
/// is not made again.
#[derive(Debug)]
pub struct RegisterWriter {
    i2c: Shared<I2cHandle>,
    /// 7-bit addresses by board.
    addresses: Box<[u8]>,
    /// Converters by board, and the current at their largest code, where there are any.
    converters: Option<(Box<[u8]>, Milliamps)>,
    /// Channels of the writer on boards that others drive too, a bit each, by board.
    own: Option<Box<[u16]>>,
    traffic: Traffic,
}

/// The four registers of a channel; full on is never among them.
fn registers(setting: Setting) -> [u8; 4] {
    let [on, off] = [setting.on, setting.off].map(|ticks| ticks.min(4095).to_le_bytes());
    let full_off = if setting.off <= setting.on { FULL } else { 0 };
    [on[0], on[1], off[0], off[1] | full_off]
}

impl RegisterWriter {
    /// A writer for boards behind an emulated bus.
    pub fn new(i2c: Shared<I2cHandle>, addresses: &[u8]) -> Self {
        Self {
            i2c,
            addresses: addresses.into(),
            converters: None,
            own: None,
            traffic: Traffic::default(),
        }
    }

    /// Returns the writer for boards that others drive too. `channels`
    /// has a bit for each channel of this writer, board by board.
    #[must_use]
    pub fn sharing(mut self, channels: &[u16]) -> Self {
        self.own = Some(channels.into());
        self
    }

    /// Returns the writer with a DAC7578 for each board, `full_scale` at its largest code.
    #[must_use]
    pub fn with_converters(mut self, addresses: &[u8], full_scale: Milliamps) -> Self {
        self.converters = Some((addresses.into(), full_scale));
        self
    }

    /// Sets the currents of an update.
    fn set_currents(&mut self, update: &Observed) -> Result<(), DriverError> {
        let Some((addresses, full_scale)) = &self.converters else {
            return Ok(());
        };
        let board = update.board();
        let address = addresses.get(usize::from(board.0)).copied();
        let address = address.ok_or(DriverError::NoSuchBoard(board))?;
        for (output, current) in (0..dac7578::CHANNELS).zip(update.currents()) {
            let Some(current) = current else {
                continue;
            };
            let code = dac7578::code_of(current.0, full_scale.0);
            let bytes = dac7578::frame(dac7578::WRITE_UPDATE, output, dac7578::data(code));
            let sent = self.i2c.write(address, &bytes);
            sent.map_err(|e| DriverError::Bus(board, e.kind()))?;
        }
        Ok(())
    }

    /// Traffic of the writer on the bus.
    pub const fn traffic(&self) -> Traffic {
        self.traffic
    }

    fn send(&mut self, board: Board, bytes: &[u8]) -> Result<(), DriverError> {
        let address = self.addresses.get(usize::from(board.0));
        let address = *address.ok_or(DriverError::NoSuchBoard(board))?;
        let sent = self.i2c.write(address, bytes);
        sent.map_err(|e| DriverError::Bus(board, e.kind()))
    }
}

impl Actuators<Observed> for RegisterWriter {
    type Error = DriverError;

    /// One write of all channels up to the last wire's, ended by one STOP. On boards that others drive too one write for
    /// each channel.
    fn apply(&mut self, update: &Observed) -> Result<(), DriverError> {
        self.set_currents(update)?;
        if self.own.is_some() {
            for (channel, setting) in (0..CHANNELS).zip(update.channels()) {
                let Some(setting) = setting else {
                    continue;
                };
                let [a, b, c, d] = registers(*setting);
                self.traffic.writes += 1;
                self.traffic.channels += 1;
                self.send(update.board(), &[regs::led(channel), a, b, c, d])?;
            }
            return Ok(());
        }
        let used = update.channels().iter().rposition(Option::is_some);
        let used = used.map_or(0, |last| last + 1);
        let mut bytes = [0; 1 + 4 * CHANNELS as usize];
        bytes[0] = regs::LED0_ON_L;
        let quads = bytes[1..].chunks_exact_mut(4).zip(update.channels());
        for (quad, setting) in quads {
            quad.copy_from_slice(&registers(setting.unwrap_or(Setting { on: 0, off: 0 })));
        }
        self.traffic.writes += 1;
        self.traffic.channels += used as u64;
        self.send(update.board(), &bytes[..1 + 4 * used])
    }

    fn all_off(&mut self) -> Result<(), DriverError> {
        let boards = (0..=u8::MAX).take(self.addresses.len());
        let off = |result: Result<(), _>, board| {
            let own = self.own.as_ref().and_then(|o| o.get(usize::from(board)));
            let one = match own.copied().filter(|own| *own != u16::MAX) {
                None => self.send(Board(board), &[regs::ALL_LED_OFF_H, FULL]),
                Some(own) => (0..CHANNELS)
                    .filter(|channel| own >> channel & 1 == 1)
                    .map(|channel| self.send(Board(board), &[regs::led(channel) + 3, FULL]))
                    .fold(Ok(()), Result::and),
            };
            result.and(one)
        };
        boards.fold(Ok(()), off)
    }
}
