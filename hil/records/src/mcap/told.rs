//! What a recording of a run says of it again: messages of its topics back to events.

use palpate_core::units::Instant;

use super::described::decode;
use super::messages::{BoardMessage, Line, TaxelCounts, stimulus};
use super::proto::packed;
use crate::trace::{Event, event};

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
        let at = Instant::from_micros(t_us);
        let event = match self {
            Self::Frames => Event::Frame(event::Frame {
                t_us,
                ..decode(message)?
            }),
            Self::Contacts => Event::Contact(event::Contact {
                t_us,
                ..decode(message)?
            }),
            Self::Truth => Event::Truth(event::Truth {
                t_us,
                ..decode(message)?
            }),
            Self::Felt => Event::Felt(event::Felt {
                t_us,
                ..decode(message)?
            }),
            Self::Boards => match decode(message)? {
                BoardMessage {
                    board,
                    pre_scale,
                    all_off: "",
                } => Event::PreScale(event::PreScale {
                    t_us,
                    board,
                    pre_scale,
                }),
                off => Event::note(at, format!("all off: {}", off.all_off)),
            },
            Self::Log => match decode(message)? {
                Line {
                    text,
                    name: "note" | "texture",
                } => Event::note(at, text.to_owned()),
                _ => return Some(None),
            },
            Self::Schedule => Event::Schedule(stimulus(t_ns, message)?.entry),
            Self::Pin(wire) => {
                let event::Edge { high, .. } = decode(message)?;
                return Some(Some(Told::Pin { t_ns, wire, high }));
            }
            Self::Wire(wire) => Event::Wire(event::Temperature {
                t_us,
                wire,
                ..decode(message)?
            }),
            Self::Skin(wire) => Event::Skin(event::Temperature {
                t_us,
                wire,
                ..decode(message)?
            }),
            Self::Taxels(module) => {
                let TaxelCounts([.., relative]) = decode(message)?;
                return Some(Some(Told::Taxels {
                    t_ns,
                    module,
                    relative: packed(relative)?,
                }));
            }
        };
        Some(Some(Told::Event(event)))
    }
}

#[cfg(test)]
#[path = "told_tests.rs"]
mod tests;
