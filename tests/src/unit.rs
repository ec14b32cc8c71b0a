//! A driver unit on a desk: registers for its bus, a letter box for its network, a host that seals its own datagrams.
//! Nothing here allocates after it is built.

use std::cell::Cell;

use embedded_hal::i2c::{ErrorKind, ErrorType, I2c, Operation};
use palpate_core::codec::link::{
    Buffer, Command, Header, Key, Kind, MOST, Planned, Refusal, Request, Said,
};
use palpate_core::guard::{HARD, Plant, WornWire};
use palpate_core::illusion::DisplayWire;
use palpate_core::units::{Board, Channel, Duration, Instant, Milliamps, Point, Ticks};
use palpate_unit::{Datagrams, NoPin, Settings, SettingsError, Unit};

const KEY: [u8; 32] = [9; 32];
/// Registers of a PCA9685 that write to all its channels: ALL_LED_ON_L and on.
const ALL_LED: usize = 0xFA;

/// Two boards as memory alone, and whether their bus answers.
pub struct Registers<'a> {
    chips: [[u8; 256]; 2],
    answers: &'a Cell<bool>,
}

impl ErrorType for Registers<'_> {
    type Error = ErrorKind;
}

impl I2c for Registers<'_> {
    fn transaction(
        &mut self,
        address: u8,
        operations: &mut [Operation<'_>],
    ) -> Result<(), ErrorKind> {
        let boards = match address {
            0x70 => 0..2,
            0x40 => 0..1,
            0x41 => 1..2,
            _ => return Err(ErrorKind::Other),
        };
        if !self.answers.get() {
            return Err(ErrorKind::Other);
        }
        for chip in &mut self.chips[boards] {
            let mut pointer = 0;
            for operation in operations.iter_mut() {
                match operation {
                    Operation::Write([first, values @ ..]) => {
                        pointer = usize::from(*first);
                        for value in values.iter() {
                            write(chip, pointer, *value);
                            pointer = (pointer + 1) % chip.len();
                        }
                    }
                    Operation::Write([]) => {}
                    Operation::Read(values) => {
                        for value in values.iter_mut() {
                            *value = chip[pointer];
                            pointer = (pointer + 1) % chip.len();
                        }
                    }
                }
            }
        }
        Ok(())
    }
}

fn write(chip: &mut [u8; 256], register: usize, value: u8) {
    chip[register] = value;
    if let Some(part) = register.checked_sub(ALL_LED).filter(|part| *part < 4) {
        (0..16).for_each(|channel| chip[6 + 4 * channel + part] = value);
    }
}

/// A unit of sixteen wires on two boards; `answers` says whether their bus does.
///
/// # Errors
/// None that its settings give cause for.
pub fn unit(
    worn: Option<WornWire>,
    answers: &Cell<bool>,
) -> Result<Unit<Registers<'_>, NoPin>, SettingsError> {
    let chips = [[0; 256]; 2];
    let settings = Settings {
        key: &KEY,
        boot: 77,
        wires: &wires(),
        addresses: &[0x40, 0x41],
        limits: HARD,
        plant: Plant::default(),
        worn,
        converters: None,
    };
    Unit::new(&settings, Registers { chips, answers }, NoPin)
}

/// Eight wires in a row on each of two boards.
pub fn wires() -> [DisplayWire; 16] {
    std::array::from_fn(|n| DisplayWire {
        place: Point::new(n as f32, 0.0),
        board: Board(n as u8 / 8),
        channel: Channel(n as u8 % 8),
    })
}

/// A stimulus of 35 ms at `onset` on each wire.
pub fn plan(onset: Instant) -> [Planned; 16] {
    wires().map(|wire| Planned {
        board: wire.board,
        channel: wire.channel,
        width: Ticks::new(148),
        current: Milliamps(0),
        at: onset,
        until: onset + Duration::from_millis(35),
    })
}

/// Holds one datagram on its way to the unit, and the last one that came back.
pub struct LetterBox {
    there: Buffer,
    /// Bytes of the datagram that waits.
    pub waits: Option<usize>,
    back: Buffer,
    /// Datagrams that came back.
    pub answers: u64,
}

impl Default for LetterBox {
    fn default() -> Self {
        Self {
            there: [0; MOST],
            waits: None,
            back: [0; MOST],
            answers: 0,
        }
    }
}

impl LetterBox {
    /// The newest datagram to the unit, and all the room behind it. It lies there after the unit has taken it.
    pub const fn there(&mut self) -> &mut Buffer {
        &mut self.there
    }
}

impl Datagrams for LetterBox {
    type Peer = ();

    fn receive(&mut self, buffer: &mut Buffer) -> Option<(usize, ())> {
        let length = self.waits.take()?;
        buffer[..length].copy_from_slice(&self.there[..length]);
        Some((length, ()))
    }

    fn send(&mut self, datagram: &[u8], (): ()) {
        self.back[..datagram.len()].copy_from_slice(datagram);
        self.answers += 1;
    }
}

/// A host with the unit's key.
pub struct Host {
    key: Key,
    unit: u64,
    sequence: u64,
}

impl Default for Host {
    fn default() -> Self {
        Self {
            key: Key::new(&KEY),
            unit: 0,
            sequence: 0,
        }
    }
}

impl Host {
    /// The unit's key.
    pub const fn key(&self) -> &Key {
        &self.key
    }

    fn header(&mut self, kind: Kind, unit: u64) -> Header {
        self.sequence += 1;
        Header {
            kind,
            host: 1,
            unit,
            sequence: self.sequence,
        }
    }

    /// Lays a knock into the letter box.
    pub fn knock(&mut self, letters: &mut LetterBox) {
        let header = self.header(Kind::Knock, 0);
        letters.waits = Some(self.key.seal(&header, &mut letters.there, |_| 0).len());
    }

    /// Takes the unit's number from the hello that came back.
    ///
    /// # Errors
    /// What came back is no hello of this unit.
    pub fn greet(&mut self, letters: &LetterBox) -> Result<(), Refusal> {
        self.unit = Header::read(&letters.back)?.unit;
        Ok(())
    }

    /// Lays a command into the letter box.
    pub fn command(
        &mut self,
        letters: &mut LetterBox,
        reading: Instant,
        (stops, request): (u32, Request),
        plan: &[Planned],
    ) {
        let header = self.header(Kind::Command, self.unit);
        let said = Said {
            reading,
            stops,
            request,
            ..Said::default()
        };
        let body = |out: &mut [u8]| Command::write(out, &said, plan);
        letters.waits = Some(self.key.seal(&header, &mut letters.there, body).len());
    }
}
