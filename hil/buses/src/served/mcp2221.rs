//! A Microchip MCP2221 USB-to-I2C bridge in its 64-byte reports (data sheet DS20005565, chapter 3).
//!
//! Pure: a report in, a report out, and behind it any embedded-hal bus. Linux drives it with its own
//! `hid-mcp2221`; what that driver asks is answered in full, the flash only as far as its start needs it.
//!
//! The bridge moves bytes when it has a transfer's last chunk, so a transfer is never torn by a slow
//! client. A write without STOP waits for what is read after it; if anything else comes, it goes out alone.

use embedded_hal::i2c::{Error as _, ErrorKind, I2c, NoAcknowledgeSource, Operation};

/// Length of a report, bytes.
pub const REPORT: usize = 64;
/// Data bytes in a report.
const CHUNK: usize = 60;
/// Bytes of an SMBus block.
const BLOCK: usize = 32;

/// First bytes of reports (3.1).
mod command {
    pub const STATUS: u8 = 0x10;
    pub const GET_DATA: u8 = 0x40;
    pub const SET_PINS: u8 = 0x50;
    pub const GET_PINS: u8 = 0x51;
    pub const SET_SRAM: u8 = 0x60;
    pub const GET_SRAM: u8 = 0x61;
    pub const RESET: u8 = 0x70;
    pub const WRITE: u8 = 0x90;
    pub const READ: u8 = 0x91;
    pub const WRITE_REPEATED: u8 = 0x92;
    pub const READ_REPEATED: u8 = 0x93;
    pub const WRITE_NO_STOP: u8 = 0x94;
    pub const READ_FLASH: u8 = 0xB0;
}

/// Arguments of the status command, and their echo in its answer (3.1.1).
const CANCEL: u8 = 0x10;
const SET_SPEED: u8 = 0x20;

/// States of the I2C engine: zero is idle. Linux's driver tells these numbers apart.
mod engine {
    /// Another controller holds the bus: EAGAIN.
    pub const BUSY: u8 = 0x01;
    /// No START was possible, or the clock stayed low: ETIMEDOUT.
    pub const START_TIMEOUT: u8 = 0x12;
    /// No device acknowledged the address: ENXIO.
    pub const ADDRESS_NACK: u8 = 0x25;
    /// A data byte was not acknowledged: EIO, the driver has no other number for it.
    pub const DATA_NACK: u8 = 0x45;
    /// Data of a read are there.
    pub const READ_COMPLETE: u8 = 0x55;
}

/// The bit of the status report for "address not acknowledged".
const NACK_BIT: u8 = 0x40;
/// Mark in place of a length: the read has failed.
const FAILED: u8 = 127;

/// A general purpose pin, 3.1.11: the kernel has a GPIO line of it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
struct GpPin {
    is_output: bool,
    high: bool,
}

/// A write that still lacks chunks.
#[derive(Clone, Debug, PartialEq, Eq)]
struct Incoming {
    command: u8,
    address: u8,
    length: usize,
    bytes: Vec<u8>,
}

/// The bridge.
#[derive(Clone, Debug)]
pub struct Mcp2221 {
    divider: u8,
    /// Code of the last transfer's end; zero for a good one.
    state: u8,
    address: u8,
    requested: usize,
    incoming: Option<Incoming>,
    /// A complete write that waits for its repeated START.
    held: Option<(u8, Vec<u8>)>,
    /// Bytes of a read, and the number of those that have been fetched.
    data: Vec<u8>,
    fetched: usize,
    reading: bool,
    pins: [GpPin; 4],
}

impl Default for Mcp2221 {
    /// State after power-on: 100 kHz asked for, nothing pending.
    fn default() -> Self {
        Self {
            divider: 117,
            state: 0,
            address: 0,
            requested: 0,
            incoming: None,
            held: None,
            data: Vec::new(),
            fetched: 0,
            reading: false,
            pins: [GpPin::default(); 4],
        }
    }
}

impl Mcp2221 {
    /// Level of a pin (0 to 3): `true` where it is driven high; `None` for an input, which floats.
    pub fn pin(&self, number: usize) -> Option<bool> {
        let pin = self.pins.get(number).filter(|pin| pin.is_output);
        pin.map(|pin| pin.high)
    }

    /// Takes a report and returns the answer; `None` where the bridge has none (a reset, no bytes at all).
    ///
    /// Short reports count as filled up with zeros. A leading zero before 64 bytes is hidraw's report
    /// number.
    pub fn answer(&mut self, report: &[u8], bus: &mut impl I2c) -> Option<[u8; REPORT]> {
        let report = match report {
            [0, rest @ ..] if rest.len() == REPORT => rest,
            _ => report,
        };
        let mut asked = [0; REPORT];
        let length = report.len().min(REPORT);
        asked[..length].copy_from_slice(&report[..length]);
        if length == 0 {
            return None;
        }
        let mut answer = [0; REPORT];
        answer[0] = asked[0];
        match asked[0] {
            command::WRITE | command::WRITE_REPEATED | command::WRITE_NO_STOP => {
                self.write(&asked, bus);
                self.tell_at_once(&mut answer);
            }
            command::READ | command::READ_REPEATED => {
                self.read(&asked, bus);
                self.tell_at_once(&mut answer);
                // Older drivers (6.1) fetch without a status, and take any number in a fetch for EIO.
                if self.state == engine::ADDRESS_NACK {
                    (answer[1], answer[2]) = (1, self.state);
                }
            }
            command::GET_DATA => {
                self.read_block(bus);
                self.fetch(&mut answer);
            }
            command::STATUS => {
                // A mere question does not end the wait for a repeated START: the driver asks one there.
                if asked[2] == CANCEL || asked[3] == SET_SPEED {
                    self.flush(bus);
                }
                self.status(&asked, &mut answer);
            }
            command::GET_PINS => {
                for (pin, told) in self.pins.iter().zip(answer[2..10].chunks_exact_mut(2)) {
                    told.copy_from_slice(&[u8::from(pin.high), u8::from(!pin.is_output)]);
                }
            }
            command::SET_PINS => {
                // Each pin's wish: whether to change the value and to which, whether to change the direction and to
                // which.
                for (pin, wish) in self.pins.iter_mut().zip(asked[2..18].chunks_exact(4)) {
                    if wish[0] != 0 {
                        pin.high = wish[1] != 0;
                    }
                    if wish[2] != 0 {
                        pin.is_output = wish[3] == 0;
                    }
                }
                answer[2..18].copy_from_slice(&asked[2..18]);
            }
            command::SET_SRAM | command::GET_SRAM | command::READ_FLASH => {}
            command::RESET => {
                *self = Self::default();
                return None;
            }
            _ => answer[1] = 1, // not a command
        }
        Some(answer)
    }

    fn write(&mut self, asked: &[u8; REPORT], bus: &mut impl I2c) {
        let (length, address) = header(asked);
        let continues =
            |i: &Incoming| i.command == asked[0] && i.address == address && i.length == length;
        let mut incoming = match self.incoming.take().filter(continues) {
            Some(incoming) => incoming,
            None => {
                self.flush(bus);
                Incoming {
                    command: asked[0],
                    address,
                    length,
                    bytes: Vec::new(),
                }
            }
        };
        let chunk = CHUNK.min(length - incoming.bytes.len());
        incoming.bytes.extend_from_slice(&asked[4..4 + chunk]);
        (self.state, self.reading) = (0, false);
        (self.address, self.requested) = (address, length);
        if incoming.bytes.len() < length {
            self.incoming = Some(incoming);
        } else if asked[0] == command::WRITE_NO_STOP {
            self.held = Some((address, incoming.bytes));
        } else {
            self.transfer(bus, address, &mut [Operation::Write(&incoming.bytes)]);
        }
    }

    fn read(&mut self, asked: &[u8; REPORT], bus: &mut impl I2c) {
        let (length, address) = header(asked);
        self.incoming = None;
        let repeated = asked[0] == command::READ_REPEATED;
        let before = self.held.take_if(|(a, _)| repeated && *a == address);
        self.flush(bus);
        let mut data = vec![0; length];
        (self.address, self.requested) = (address, length);
        match before {
            Some((_, bytes)) => self.transfer(
                bus,
                address,
                &mut [Operation::Write(&bytes), Operation::Read(&mut data)],
            ),
            None => self.transfer(bus, address, &mut [Operation::Read(&mut data)]),
        }
        if self.state != 0 {
            data.clear();
        }
        (self.data, self.fetched, self.reading) = (data, 0, true);
    }

    /// Reads the block that Linux's driver expects. It never asks for the bytes of an SMBus block (6.1 to 6.12 at
    /// least): after the register's write it fetches them. It expects a length and as many bytes as a block has at
    /// most.
    fn read_block(&mut self, bus: &mut impl I2c) {
        let Some((address, bytes)) = self.held.take() else {
            return;
        };
        let mut data = vec![0; 1 + BLOCK];
        data[0] = BLOCK as u8;
        self.transfer(
            bus,
            address,
            &mut [Operation::Write(&bytes), Operation::Read(&mut data[1..])],
        );
        (self.data, self.fetched, self.reading) = (data, 0, true);
    }

    /// Sends a write that waits for a repeated START which has not come.
    fn flush(&mut self, bus: &mut impl I2c) {
        if let Some((address, bytes)) = self.held.take() {
            self.transfer(bus, address, &mut [Operation::Write(&bytes)]);
        }
    }

    fn transfer(&mut self, bus: &mut impl I2c, address: u8, operations: &mut [Operation<'_>]) {
        self.state = match bus.transaction(address, operations) {
            Ok(()) => 0,
            Err(error) => match error.kind() {
                ErrorKind::NoAcknowledge(NoAcknowledgeSource::Data) => engine::DATA_NACK,
                ErrorKind::NoAcknowledge(_) => engine::ADDRESS_NACK,
                ErrorKind::ArbitrationLoss => engine::BUSY,
                _ => engine::START_TIMEOUT,
            },
        };
    }

    /// Names failures that have nothing to do with the chip in the transfer's own answer; the status and the fetch tell
    /// a missing acknowledge.
    fn tell_at_once(&self, answer: &mut [u8; REPORT]) {
        if matches!(self.state, engine::BUSY | engine::START_TIMEOUT) {
            (answer[1], answer[2]) = (1, self.state);
        }
    }

    fn fetch(&mut self, answer: &mut [u8; REPORT]) {
        if !self.reading {
            answer[1] = 0x41; // 3.1.10: no data to give
            return;
        }
        if self.state != 0 {
            (answer[2], answer[3]) = (self.state, FAILED);
            self.reading = false;
            return;
        }
        let rest = &self.data[self.fetched..];
        let chunk = rest.len().min(CHUNK);
        answer[4..4 + chunk].copy_from_slice(&rest[..chunk]);
        self.fetched += chunk;
        answer[3] = chunk as u8; // at most 60
        if chunk > 0 {
            // Also between chunks: older drivers take no other state with data.
            answer[2] = engine::READ_COMPLETE;
        }
        self.reading = self.fetched < self.data.len();
    }

    fn status(&mut self, asked: &[u8; REPORT], answer: &mut [u8; REPORT]) {
        if asked[2] == CANCEL {
            let busy = self.incoming.take().is_some() || self.state != 0;
            answer[2] = if busy { CANCEL } else { CANCEL + 1 };
            (self.state, self.reading) = (0, false);
        }
        if asked[3] == SET_SPEED {
            // Earlier failures are over: the driver sets the speed before each transfer.
            (answer[3], answer[4]) = (SET_SPEED, asked[4]);
            (self.divider, self.state) = (asked[4], 0);
        }
        answer[8] = self.state;
        answer[9..11].copy_from_slice(&(self.requested as u16).to_le_bytes());
        answer[11..13].copy_from_slice(&(self.fetched as u16).to_le_bytes());
        answer[14] = self.divider;
        answer[16] = self.address << 1;
        if self.state == engine::ADDRESS_NACK {
            answer[20] = NACK_BIT;
        }
        (answer[22], answer[23]) = (1, 1); // SCL and SDA are high
        answer[25] = u8::from(self.reading);
        answer[46..50].copy_from_slice(b"A612"); // hardware and firmware revisions
    }
}

/// Length and 7-bit address of a transfer.
const fn header(asked: &[u8; REPORT]) -> (usize, u8) {
    (
        u16::from_le_bytes([asked[1], asked[2]]) as usize,
        asked[3] >> 1,
    )
}
