//! Messages of a recording's topics turned back to events.

use palpate_core::units::Instant;

use super::described::decode;
use super::messages::{BoardMessage, Line, TaxelCounts, stimulus};
use super::proto::packed;
use crate::trace::{Event, event};

/// Content of a message of a run.
#[derive(Clone, Debug, PartialEq)]
pub enum Told {
    /// Something happened.
    Event(Event),
    /// The output of a wire changed; its board and channel stand nowhere in the message.
    Pin {
        /// Time, nanoseconds.
        t_ns: u64,
        /// Wire index in the display's layout.
        wire: u16,
        /// New state.
        high: bool,
    },
    /// Readings of the taxels of a module: the distance of each from its reference, raw counts.
    Taxels {
        /// Time, nanoseconds.
        t_ns: u64,
        /// The module, as it is numbered among those that are recorded.
        module: u16,
        /// A number per taxel.
        relative: Vec<u16>,
    },
}

impl Told {
    /// Time of the event, nanoseconds.
    #[must_use]
    pub fn t_ns(&self) -> u64 {
        match self {
            Self::Event(event) => event.t_ns(),
            Self::Pin { t_ns, .. } | Self::Taxels { t_ns, .. } => *t_ns,
        }
    }
}

/// A topic by its name.
#[derive(Clone, Debug)]
pub(super) struct Topic {
    /// The name without the number of a wire or module.
    what: String,
    number: u16,
}

impl Topic {
    pub(super) fn named(name: &str) -> Self {
        let (mut what, mut number) = (Vec::new(), 0);
        for part in name.split('/') {
            // Modules and wires alone are numbered.
            let is_numbered = matches!(what.last(), Some(&("taxels" | "wire")));
            match part.parse().ok().filter(|_| is_numbered) {
                Some(of) => number = of,
                None => what.push(part),
            }
        }
        let what = what.join("/");
        Self { what, number }
    }

    /// Reads a message of the topic. The outer `None` is a damaged message; the inner one is a message that is no event, or
    /// that another topic tells better.
    pub(super) fn read(&self, t_ns: u64, message: &[u8]) -> Option<Option<Told>> {
        let t_us = t_ns / 1000;
        let at = Instant::from_micros(t_us);
        let wire = self.number;
        let event = match &*self.what {
            "/frames" => Event::Frame(event::Frame {
                t_us,
                ..decode(message)?
            }),
            "/contacts" => Event::Contact(event::Contact {
                t_us,
                ..decode(message)?
            }),
            "/truth" => Event::Truth(event::Truth {
                t_us,
                ..decode(message)?
            }),
            "/felt" => Event::Felt(event::Felt {
                t_us,
                ..decode(message)?
            }),
            "/boards" => match decode(message)? {
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
            "/events" => match decode(message)? {
                Line {
                    text,
                    name: "note" | "texture",
                    ..
                } => Event::note(at, text.to_owned()),
                _ => return Some(None),
            },
            "/wire/schedule" => Event::Schedule(stimulus(t_ns, message)?.entry),
            "/wire/pin" => {
                let event::Edge { high, .. } = decode(message)?;
                return Some(Some(Told::Pin { t_ns, wire, high }));
            }
            "/wire/temperature" => Event::Wire(event::Temperature {
                t_us,
                wire,
                ..decode(message)?
            }),
            "/wire/skin" => Event::Skin(event::Temperature {
                t_us,
                wire,
                ..decode(message)?
            }),
            "/taxels" => {
                let TaxelCounts([.., relative]) = decode(message)?;
                return Some(Some(Told::Taxels {
                    t_ns,
                    module: self.number,
                    relative: packed(relative)?,
                }));
            }
            _ => return Some(None),
        };
        Some(Some(Told::Event(event)))
    }
}

#[cfg(test)]
#[path = "told_tests.rs"]
mod tests;
