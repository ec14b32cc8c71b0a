//! State of a run for a live view, kept up by the run's events.

use std::collections::VecDeque;

use palpate_core::skin::Layout;
use palpate_records::trace::{Event, Header, PlaceUm};
use palpate_records::words::texture;

/// Lines of the story that are kept.
const LINES: usize = 32;
/// Time after its burst for which a wire counts as driven, so that the eye can follow, microseconds.
const AFTERGLOW_US: u64 = 250_000;
/// Frames over which the rate is taken.
const RATE_OVER: usize = 64;

/// A contact of the newest frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Contact {
    /// Module of the contact.
    pub module: u16,
    /// Identity of the contact.
    pub id: u32,
    /// Place on the module.
    pub place: PlaceUm,
    /// Raw counts.
    pub counts: u32,
    /// Level of the contact.
    pub level: u16,
}

/// A wire of the display.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Wire {
    /// Board of the wire.
    pub board: u8,
    /// Channel of the wire.
    pub channel: u8,
    /// Width of its last pulses, ticks of 4096.
    pub ticks: u16,
    /// End of its last burst.
    pub until_us: u64,
    /// Temperature of the wire, thousandths of a degree Celsius, where it is known.
    pub wire_mc: Option<i32>,
    /// Temperature of the skin under the wire, thousandths of a degree Celsius, where it is known.
    pub skin_mc: Option<i32>,
}

/// The state of a run.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct View {
    /// Scene and bench of the run.
    pub title: String,
    /// The time of the run and its end.
    pub now_us: u64,
    /// Time at which the run ends.
    pub end_us: u64,
    /// Places of the taxels on the skin's plane.
    pub taxels: Vec<PlaceUm>,
    /// Centres of the modules on the skin's plane.
    pub origins: Vec<PlaceUm>,
    /// The newest relative reading of every taxel, raw counts; NaN for one that is left out.
    pub counts: Vec<f32>,
    /// Frames so far.
    pub frames: u32,
    /// Times of the newest frames.
    times: VecDeque<u64>,
    /// Contacts of the newest frame.
    pub contacts: Vec<Contact>,
    /// The display's wires.
    pub wires: Vec<Wire>,
    /// Stimuli with a pulse.
    pub stimuli: u64,
    /// Stimuli of which the guard applied something other than was requested.
    pub limited: u64,
    /// Events in words, the newest last.
    pub story: VecDeque<(u64, String)>,
    /// The newest window of texture in words; empty without one.
    pub texture: String,
    /// Index of the display among several, from 0, and their number.
    pub which: Option<(usize, usize)>,
    /// Sensor buses in words, a line each.
    pub buses: Vec<String>,
}

impl View {
    /// A view before the first event.
    pub fn new(header: &Header, layout: &Layout, end_us: u64) -> Self {
        let source = header.source.words();
        let (mut taxels, mut origins) = (Vec::new(), Vec::new());
        for module in layout.modules() {
            let origin = PlaceUm::from(module.origin());
            origins.push(origin);
            taxels.extend(
                module
                    .points()
                    .iter()
                    .map(|p| shifted(PlaceUm::from(*p), origin)),
            );
        }
        let wire = |w: &palpate_records::trace::WireInfo| Wire {
            board: w.board,
            channel: w.channel,
            ..Wire::default()
        };
        Self {
            title: format!(
                "{} on {} ({source}), seed {}",
                header.scene, header.bench, header.seed
            ),
            end_us,
            counts: vec![0.0; taxels.len()],
            taxels,
            origins,
            wires: header.wires.iter().map(wire).collect(),
            ..Self::default()
        }
    }

    /// Takes in events.
    pub fn observe(&mut self, events: &[Event]) {
        for event in events {
            match event {
                Event::Frame(frame) => {
                    self.frames += 1;
                    self.contacts.clear();
                    self.times.push_back(frame.t_us);
                    if self.times.len() > RATE_OVER {
                        self.times.pop_front();
                    }
                }
                Event::Contact(now) => self.contacts.push(Contact {
                    module: now.module,
                    id: now.contact,
                    place: now.place,
                    counts: now.intensity_milli / 1000,
                    level: now.level,
                }),
                Event::Schedule(entry) => {
                    let ticks = entry.width().get();
                    let output = (entry.board.0, entry.channel.0);
                    let wire = self.wires.iter_mut();
                    if let Some(wire) = wire.into_iter().find(|w| (w.board, w.channel) == output) {
                        if ticks > 0 {
                            wire.ticks = ticks;
                        }
                        wire.until_us = entry.until.as_micros();
                    }
                    self.stimuli += u64::from(ticks > 0);
                    if let Some(reason) = entry.reason {
                        self.limited += 1;
                        let (at, asked) = (entry.at.as_micros(), entry.requested.get());
                        let (board, channel) = output;
                        let word = reason.word();
                        self.tell(
                            at,
                            format!("limiter {board}:{channel} {ticks} of {asked} ticks: {word}"),
                        );
                    }
                }
                Event::AllOff(off) => {
                    for wire in self.wires.iter_mut().filter(|w| w.board == off.board) {
                        wire.until_us = 0;
                    }
                    let text = format!("board {} all off: {}", off.board, off.cause);
                    self.tell(off.t_us, text);
                }
                Event::Wire(now) => {
                    if let Some(wire) = self.wires.get_mut(usize::from(now.wire)) {
                        wire.wire_mc = Some(now.milli_c);
                    }
                }
                Event::Skin(now) => {
                    if let Some(wire) = self.wires.get_mut(usize::from(now.wire)) {
                        wire.skin_mc = Some(now.milli_c);
                    }
                }
                Event::Latent(window) => self.texture = texture(window),
                Event::Note(note) => self.tell(note.t_us, note.text.clone()),
                _ => {}
            }
        }
    }

    fn tell(&mut self, t_us: u64, text: String) {
        self.story.push_back((t_us, text));
        if self.story.len() > LINES {
            self.story.pop_front();
        }
    }

    /// Frames a second; 0 before there are two.
    pub fn rate_hz(&self) -> f64 {
        match (self.times.front(), self.times.back()) {
            (Some(first), Some(last)) if last > first => {
                (self.times.len() - 1) as f64 * 1e6 / (last - first) as f64
            }
            _ => 0.0,
        }
    }

    /// Tells whether a wire is driven, or was a moment ago.
    pub fn is_driven(&self, wire: &Wire) -> bool {
        wire.ticks > 0 && self.now_us < wire.until_us.saturating_add(AFTERGLOW_US)
    }

    /// Place of a contact on the skin's plane.
    pub fn place(&self, contact: &Contact) -> PlaceUm {
        let origin = self.origins.get(usize::from(contact.module));
        shifted(contact.place, origin.copied().unwrap_or_default())
    }
}

fn shifted(place: PlaceUm, origin: PlaceUm) -> PlaceUm {
    PlaceUm {
        x: place.x.saturating_add(origin.x),
        y: place.y.saturating_add(origin.y),
    }
}
