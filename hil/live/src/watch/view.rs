//! What a live view shows: the state of a run, kept up by its events.

use std::collections::VecDeque;

use palpate_core::skin::Layout;
use palpate_records::trace::{Event, Header, PlaceUm};
use palpate_records::words::texture;

/// Lines of the story that are kept.
const LINES: usize = 32;
/// A wire counts as driven for so long after its burst, so that the eye can follow, microseconds.
const AFTERGLOW_US: u64 = 250_000;
/// The rate of frames is that of so many of them.
const RATE_OVER: usize = 64;

/// A contact of the newest frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Contact {
    /// Its module.
    pub module: u16,
    /// Its identity.
    pub id: u32,
    /// Its place on the module.
    pub place: PlaceUm,
    /// Raw counts.
    pub counts: u32,
    /// Its level.
    pub level: u16,
}

/// A wire of the display.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Wire {
    /// Its board.
    pub board: u8,
    /// Its channel.
    pub channel: u8,
    /// Width of its last pulses, ticks of 4096.
    pub ticks: u16,
    /// End of its last burst.
    pub until_us: u64,
    /// Thousandths of a degree Celsius, where anybody knows.
    pub wire_mc: Option<i32>,
    /// The skin under it.
    pub skin_mc: Option<i32>,
}

/// The state of a run.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct View {
    /// What is run, on what.
    pub title: String,
    /// The time of the run and its end.
    pub now_us: u64,
    /// When it will end.
    pub end_us: u64,
    /// Where the taxels lie on the skin's plane.
    pub taxels: Vec<PlaceUm>,
    /// Where the modules' own centres lie there.
    pub origins: Vec<PlaceUm>,
    /// The newest relative reading of every taxel, raw counts; NaN for one that is left out.
    pub counts: Vec<f32>,
    /// Frames so far.
    pub frames: u32,
    /// Times of the newest.
    times: VecDeque<u64>,
    /// Contacts of the newest frame.
    pub contacts: Vec<Contact>,
    /// The display's wires.
    pub wires: Vec<Wire>,
    /// Stimuli with a pulse.
    pub stimuli: u64,
    /// Times the guard applied something other than what was requested.
    pub limited: u64,
    /// What happened, the newest last.
    pub story: VecDeque<(u64, String)>,
    /// The newest window of texture in words; empty without one.
    pub texture: String,
    /// Which of several displays this is of, from 0, and how many there are.
    pub which: Option<(usize, usize)>,
    /// A line a sensor bus.
    pub buses: Vec<String>,
}

impl View {
    /// Before anything has happened.
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

    /// Takes in what happened.
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

    /// Whether a wire is driven, or was a moment ago.
    pub fn is_driven(&self, wire: &Wire) -> bool {
        wire.ticks > 0 && self.now_us < wire.until_us.saturating_add(AFTERGLOW_US)
    }

    /// Where a contact lies on the skin's plane.
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
