//! What a recording of a run says of it again: messages of its topics back to events.

use palpate_core::schedule::Entry;
use palpate_core::units::{Board, Channel};

use super::messages::entry;
use super::proto::{Fields, Value, packed};
use crate::trace::{EnergyPermille, Event, FeltAt, PlaceUm, event};

/// What a message of a run says.
#[derive(Clone, Debug, PartialEq)]
pub enum Told {
    /// Something happened.
    Event(Event),
    /// The output of a wire changed; its board and channel stand nowhere in the message.
    Pin {
        /// When, nanoseconds.
        t_ns: u64,
        /// Wire index in the display's layout.
        wire: u16,
        /// New state.
        high: bool,
    },
    /// What the taxels of a module read: the distance of each from its reference, raw counts.
    Taxels {
        /// When, nanoseconds.
        t_ns: u64,
        /// The module, as it is numbered among those that are recorded.
        module: u16,
        /// A number per taxel.
        relative: Vec<u16>,
    },
}

impl Told {
    /// When it happened, nanoseconds.
    #[must_use]
    pub fn t_ns(&self) -> u64 {
        match self {
            Self::Event(event) => event.t_ns(),
            Self::Pin { t_ns, .. } | Self::Taxels { t_ns, .. } => *t_ns,
        }
    }
}

/// A topic whose messages say something of the run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Topic {
    Frames,
    Contacts,
    Truth,
    Felt,
    Boards,
    Log,
    Schedule,
    Pin(u16),
    Wire(u16),
    Skin(u16),
    Taxels(u16),
}

impl Topic {
    /// By its name.
    pub(super) fn of(name: &str) -> Option<Self> {
        Some(match name {
            "/frames" => Self::Frames,
            "/contacts" => Self::Contacts,
            "/truth" => Self::Truth,
            "/felt" => Self::Felt,
            "/boards" => Self::Boards,
            "/events" => Self::Log,
            _ => {
                if let Some(module) = name.strip_prefix("/taxels/") {
                    return Some(Self::Taxels(module.parse().ok()?));
                }
                let (wire, what) = name.strip_prefix("/wire/")?.split_once('/')?;
                let wire = wire.parse().ok()?;
                match what {
                    "schedule" => Self::Schedule,
                    "pin" => Self::Pin(wire),
                    "temperature" => Self::Wire(wire),
                    "skin" => Self::Skin(wire),
                    _ => return None,
                }
            }
        })
    }

    /// What a message of it says: `None` for a damaged one, and inside for what another topic says better.
    pub(super) fn read(self, t_ns: u64, message: &[u8]) -> Option<Option<Told>> {
        let t_us = t_ns / 1000;
        let fields = Numbered::of(message)?;
        let event = match self {
            Self::Frames => Event::Frame(event::Frame {
                t_us,
                frame: fields.small(1)?,
                in_contact: fields.small(2)?,
                peak_counts: fields.small(3)?,
            }),
            Self::Contacts => Event::Contact(event::Contact {
                t_us,
                frame: fields.small(1)?,
                module: fields.small(2)?,
                contact: fields.small(3)?,
                place: fields.place(4),
                intensity_milli: (fields.real(6) * 1e3).round() as u32,
                level: fields.small(7)?,
                members: fields.small(8)?,
            }),
            Self::Truth => Event::Truth(event::Truth {
                t_us,
                place: fields.place(1),
                force_mn: (fields.real(3) * 1e3).round() as u32,
            }),
            Self::Felt => fields.felt(t_us)?,
            Self::Boards => match fields.data(3) {
                [] => Event::PreScale(event::PreScale {
                    t_us,
                    board: fields.small(1)?,
                    pre_scale: fields.small(2)?,
                }),
                cause => Event::Note(event::Note {
                    t_us,
                    text: format!("all off: {}", String::from_utf8_lossy(cause)),
                }),
            },
            Self::Log => match fields.data(4) {
                b"note" | b"texture" => Event::Note(event::Note {
                    t_us,
                    text: String::from_utf8_lossy(fields.data(3)).into_owned(),
                }),
                _ => return Some(None),
            },
            Self::Schedule => {
                let (read, _, _) = entry(t_ns, message)?;
                let requested_until = match fields.number(11) {
                    0 => read.until,
                    _ => read.requested_until,
                };
                Event::Schedule(Entry {
                    board: Board(fields.small(1)?),
                    channel: Channel(fields.small(2)?),
                    requested_until,
                    ..read
                })
            }
            Self::Pin(wire) => {
                let high = fields.number(1) != 0;
                return Some(Some(Told::Pin { t_ns, wire, high }));
            }
            Self::Wire(wire) => Event::Wire(event::Temperature {
                t_us,
                wire,
                milli_c: fields.milli(1),
            }),
            Self::Skin(wire) => Event::Skin(event::Temperature {
                t_us,
                wire,
                milli_c: fields.milli(1),
            }),
            Self::Taxels(module) => {
                return Some(Some(Told::Taxels {
                    t_ns,
                    module,
                    relative: packed(fields.data(4))?,
                }));
            }
        };
        Some(Some(Told::Event(event)))
    }
}

/// Most fields of a message that is read here.
const FIELDS: usize = 16;

/// The fields of a message by number; what was left out is 0 or empty, as proto3 has it.
struct Numbered<'a> {
    numbers: [u64; FIELDS],
    data: [&'a [u8]; FIELDS],
}

impl<'a> Numbered<'a> {
    fn of(message: &'a [u8]) -> Option<Self> {
        let mut all = Self {
            numbers: [0; FIELDS],
            data: [&[]; FIELDS],
        };
        for field in Fields::new(message) {
            let (number, value) = field?;
            let Some(at) = usize::try_from(number).ok().filter(|n| *n < FIELDS) else {
                continue; // of a later version
            };
            match value {
                Value::Number(n) | Value::Fixed64(n) => all.numbers[at] = n,
                Value::Fixed32(n) => all.numbers[at] = u64::from(n),
                Value::Data(bytes) => all.data[at] = bytes,
            }
        }
        Some(all)
    }

    const fn number(&self, field: usize) -> u64 {
        self.numbers[field]
    }

    fn small<T: TryFrom<u64>>(&self, field: usize) -> Option<T> {
        T::try_from(self.numbers[field]).ok()
    }

    const fn real(&self, field: usize) -> f64 {
        f64::from_bits(self.numbers[field])
    }

    const fn data(&self, field: usize) -> &'a [u8] {
        self.data[field]
    }

    /// Thousandths of a number.
    fn milli(&self, field: usize) -> i32 {
        (self.real(field) * 1e3).round() as i32
    }

    /// A place whose x, in millimetres, is this field and whose y the next.
    fn place(&self, field: usize) -> PlaceUm {
        PlaceUm {
            x: self.milli(field),
            y: self.milli(field + 1),
        }
    }

    fn felt(&self, t_us: u64) -> Option<Event> {
        // No number: no wire moved.
        let met = (!self.real(5).is_nan()).then(|| FeltAt {
            energy: self.place(5),
            amplitude: self.place(7),
            level_mdb: self.milli(12),
            tap: self.number(13) != 0,
        });
        Some(Event::Felt(event::Felt {
            t_us,
            target: self.place(1),
            inside: self.number(3) != 0,
            met,
            energy: EnergyPermille {
                requested: self.small(9)?,
                applied: self.small(10)?,
                felt: self.small(11)?,
            },
        }))
    }
}

#[cfg(test)]
#[path = "told_tests.rs"]
mod tests;
