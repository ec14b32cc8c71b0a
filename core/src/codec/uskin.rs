//! uSkin taxel readings and commands on CAN, as MTB3 boards send and take them.
//!
//! No public specification exists; this follows the maker's 2019 code and the independent drivers
//! that agree with it byte for byte. Two layers: [`Raw`] is a view on the eight bytes, [`Message`] is
//! what they mean. One frame carries one taxel; nothing on the bus says which scan it belongs to.

use super::can::CanFrame;

/// Byte 0 of a data frame as the boards send it; readers skip it.
const HEAD: u8 = 0x93;
/// Byte 7 of a data frame as the boards send it (0x0C..0x0F were seen); readers skip it.
const TAIL: u8 = 0x0F;
/// Byte 0 of every command; with a length of 2 it tells a command from data under a shared identifier.
const COMMAND: u8 = 0x07;
/// Identifier of board c's own command is `COMMAND_ID | c`.
pub const COMMAND_ID: u16 = 0x200;
/// The board number that means every board.
pub const ALL_BOARDS: u8 = 0xF;

/// One taxel's three axes in raw counts, uncalibrated. `z` rises when pressed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct Reading {
    /// Shear along the rows, counts.
    pub x: u16,
    /// Shear along the columns, counts.
    pub y: u16,
    /// Normal, counts.
    pub z: u16,
}

/// A view on the bytes of a data frame: length checked, nothing interpreted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Raw<'a>(&'a [u8]);

impl<'a> Raw<'a> {
    /// The view, if there are eight bytes, or seven as some boards send.
    #[inline]
    pub fn new(data: &'a [u8]) -> Option<Self> {
        matches!(data.len(), 7 | 8).then_some(Self(data))
    }

    /// The three axes: bytes 1 to 6, most significant byte first.
    #[inline]
    pub fn reading(self) -> Reading {
        let [_, xh, xl, yh, yl, zh, zl, ..] = *self.0 else {
            return Reading::default(); // `new` refused anything shorter
        };
        Reading {
            x: u16::from_be_bytes([xh, xl]),
            y: u16::from_be_bytes([yh, yl]),
            z: u16::from_be_bytes([zh, zl]),
        }
    }
}

/// Place of a sensor chip on its board.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct ChipPlace {
    /// SDA line, 0 ..= 7.
    pub sda: u8,
    /// Chip on that line, 0 ..= 15.
    pub chip: u8,
}

/// The data identifier of a chip, `sda << 8 | chip << 4 | board`; `None` where a number does not fit its field.
pub fn id(board: u8, place: ChipPlace) -> Option<u16> {
    let [c, s, k] = [board, place.sda, place.chip].map(u16::from);
    (c < 16 && s < 8 && k < 16).then_some(s << 8 | k << 4 | c)
}

/// The board and the chip that an identifier of 11 bits names as those of data.
pub const fn sender(id: u16) -> (u8, ChipPlace) {
    let place = ChipPlace {
        sda: (id >> 8 & 0x7) as u8,
        chip: (id >> 4 & 0xF) as u8,
    };
    ((id & 0xF) as u8, place)
}

/// Command of a host to a board. Boards do not answer.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Command {
    /// The board spoken to, 0 ..= 14, or [`ALL_BOARDS`].
    pub board: u8,
    /// Start sending, or stop.
    pub start: bool,
}

impl Command {
    /// Tells whether the command is meant for board `c`.
    pub const fn is_for(self, c: u8) -> bool {
        self.board == ALL_BOARDS || self.board == c
    }

    /// The frame `20c#0700` (start) or `20c#0701` (stop); `None` for a board number over 15.
    pub fn encode(self) -> Option<CanFrame> {
        if self.board > ALL_BOARDS {
            return None;
        }
        let id = COMMAND_ID | u16::from(self.board);
        CanFrame::new(id, &[COMMAND, u8::from(!self.start)])
    }
}

/// One taxel's reading with the sender it came from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Data {
    /// The sending board.
    pub board: u8,
    /// The chip on that board.
    pub place: ChipPlace,
    /// Reading of the taxel's three axes.
    pub reading: Reading,
}

/// Meaning of a frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Message {
    /// A taxel reading.
    Data(Data),
    /// A command from a host.
    Command(Command),
}

/// Reasons for which a frame means nothing here.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum Rejected {
    /// Neither a data frame's seven or eight bytes nor a command's two.
    #[error("neither 7 or 8 data bytes nor a 2-byte command")]
    Length,
    /// Two bytes that are no known command.
    #[error("unknown command")]
    UnknownCommand,
}

/// The meaning of a frame. Commands are told from data by their length and byte 0, since their
/// identifiers meet (board c's command `0x20c` is also its chip on SDA line 2, chip 0).
pub fn decode(frame: &CanFrame) -> Result<Message, Rejected> {
    if let [head, argument] = *frame.data() {
        let known = head == COMMAND && argument < 2 && frame.id() & !0xF == COMMAND_ID;
        return known
            .then_some(Message::Command(Command {
                board: (frame.id() & 0xF) as u8,
                start: argument == 0,
            }))
            .ok_or(Rejected::UnknownCommand);
    }
    let reading = Raw::new(frame.data()).ok_or(Rejected::Length)?.reading();
    let (board, place) = sender(frame.id());
    Ok(Message::Data(Data {
        board,
        place,
        reading,
    }))
}

/// The data frame of one taxel; `None` where the board or the place does not fit its field.
pub fn encode(board: u8, place: ChipPlace, reading: Reading) -> Option<CanFrame> {
    data_frame(id(board, place)?, reading)
}

/// The data frame of a reading under an identifier already known; `None` for one over 11 bits.
pub fn data_frame(id: u16, reading: Reading) -> Option<CanFrame> {
    let ([xh, xl], [yh, yl], [zh, zl]) = (
        reading.x.to_be_bytes(),
        reading.y.to_be_bytes(),
        reading.z.to_be_bytes(),
    );
    CanFrame::new(id, &[HEAD, xh, xl, yh, yl, zh, zl, TAIL])
}

/// Wiring of one board's taxels: rows are SDA lines, columns are chips counted from the right.
///
/// A second module on the same board has its chips from 8 on (seen: SDA 0 and 1 with chips 0 to 3 and
/// 8 to B).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Wiring {
    rows: u8,
    columns: u8,
    modules: u8,
}

impl Wiring {
    /// One flat 4x4 module.
    pub const FLAT: Self = Self {
        rows: 4,
        columns: 4,
        modules: 1,
    };
    /// One curved fingertip, four SDA lines of six chips (row 0 at the tip).
    pub const CURVED: Self = Self {
        rows: 4,
        columns: 6,
        modules: 1,
    };

    /// `rows` SDA lines (1 ..= 8) of `columns` chips (1 ..= 8) for one or two modules; `None` otherwise.
    pub fn new(rows: u8, columns: u8, modules: u8) -> Option<Self> {
        let fits = |n| (1..=8).contains(&n);
        (fits(rows) && fits(columns) && (1..=2).contains(&modules)).then_some(Self {
            rows,
            columns,
            modules,
        })
    }

    /// SDA lines of a module.
    pub const fn rows(self) -> u8 {
        self.rows
    }

    /// Chips on a line of a module.
    pub const fn columns(self) -> u8 {
        self.columns
    }

    /// Modules on the board, one or two.
    pub const fn modules(self) -> u8 {
        self.modules
    }

    /// Taxels of one module.
    pub const fn taxels(self) -> usize {
        self.rows as usize * self.columns as usize
    }

    /// The module on the board and the taxel in it, `columns * row + column` with row = SDA line and
    /// column = `columns - 1 - chip`; `None` for a place that is not wired.
    pub fn taxel(self, place: ChipPlace) -> Option<(u8, usize)> {
        let (module, chip) = (place.chip / 8, place.chip % 8);
        (place.sda < self.rows && chip < self.columns && module < self.modules).then(|| {
            let column = self.columns - 1 - chip;
            (
                module,
                usize::from(self.columns) * usize::from(place.sda) + usize::from(column),
            )
        })
    }

    /// The place of a taxel, the inverse of [`Self::taxel`].
    pub fn place(self, module: u8, taxel: usize) -> Option<ChipPlace> {
        if module >= self.modules || taxel >= self.taxels() {
            return None;
        }
        let columns = usize::from(self.columns);
        Some(ChipPlace {
            sda: (taxel / columns) as u8,
            chip: 8 * module + self.columns - 1 - (taxel % columns) as u8,
        })
    }

    /// Position in the order of a scan on the wire: chip-major, SDA line inner (`4 k + s` on a 4x4
    /// module), the second module after the first.
    pub fn order(self, place: ChipPlace) -> Option<usize> {
        let (module, _) = self.taxel(place)?;
        let in_module =
            usize::from(place.chip % 8) * usize::from(self.rows) + usize::from(place.sda);
        Some(usize::from(module) * self.taxels() + in_module)
    }

    /// The place at position `n` of a scan, the inverse of [`Self::order`].
    pub fn nth(self, n: usize) -> Option<ChipPlace> {
        let rows = usize::from(self.rows);
        let (module, rest) = (n / self.taxels(), n % self.taxels());
        (module < usize::from(self.modules)).then(|| ChipPlace {
            sda: (rest % rows) as u8,
            chip: (8 * module + rest / rows) as u8,
        })
    }
}

#[cfg(test)]
mod tests;
