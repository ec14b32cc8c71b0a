//! Painter: pictures from events and a look at a session.

use palpate_core::projector::Projector;
use palpate_core::units::Point;
use palpate_emulators::worn::DisplayTotals;
use palpate_files::{Setup, Touch};
use palpate_records::trace::{Driven, Event, Header, PlaceUm, event};

use super::head::{origin, pair, shown};
use super::{Burst, Contact, Felt, Picture, State, Wants};
use crate::band;

/// Time between two looks at temperatures and shares of limits, microseconds: a reader sees no more.
const LOOK_US: u64 = 100_000;
/// Time between two looks at totals, which only grow, microseconds.
const TOTALS_US: u64 = 1_000_000;
/// Pictures of less time than this follow single pulses, microseconds: each has temperatures of its own, and totals come
/// as often as they are looked at elsewhere.
const CLOSE_US: u64 = 10_000;

/// Keeps facts of past events that later pictures need.
#[derive(Clone, Debug)]
pub struct Painter {
    /// Board and channel of each wire.
    outputs: Vec<(u8, u8)>,
    /// Taxels of each module, and whether it is shown.
    modules: Vec<(usize, bool)>,
    /// The scene's touches on shown modules, each with the module's centre, mm.
    touches: Vec<(Touch, [f32; 2])>,
    memory: Memory,
    /// Level at 5 and 95 % of all that is not measured of the bench, dB.
    band_db: Option<[f64; 2]>,
    /// Results of the newest looks: temperatures, shares of limits, totals.
    warm: Vec<[f64; 2]>,
    used: Vec<(&'static str, f64)>,
    totals: Option<DisplayTotals>,
    /// Times of the newest looks at temperatures and at totals, and of the newest picture.
    looked_us: [Option<u64>; 2],
    shown_us: u64,
}

/// Facts that a painter remembers of past events.
#[derive(Clone, Debug)]
pub(crate) struct Memory {
    contacts: Vec<Contact>,
    frames: u32,
    /// Temperatures by events, where nothing else measures them: each wire and the skin under it, degrees C.
    pub(crate) warm: Vec<[f64; 2]>,
    /// Counts of the stimuli, and the hottest skin that an event told of, thousandths of a degree Celsius.
    pub(crate) driven: Driven,
    pub(crate) hottest_mc: Option<i32>,
}

fn mm(place: PlaceUm) -> [f64; 2] {
    [f64::from(place.x) / 1e3, f64::from(place.y) / 1e3]
}

/// Rounds to thousandths: a page shows no more, and long texts take time to write and to read. A quotient is the number
/// nearest to those digits, a product need not be.
fn short(value: f64) -> f64 {
    libm::round(value * 1e3) / 1e3
}

impl Painter {
    /// A painter for a session that has not begun.
    #[must_use]
    pub fn new(setup: &Setup, header: &Header, projector: &Projector) -> Self {
        let (shown, modules) = (shown(setup, projector), projector.layout().modules());
        let touches = setup.scene.value.touches.iter();
        let touches = touches.filter(|touch| shown.contains(&touch.module));
        let placed = touches.filter_map(|touch| {
            let module = modules.get(touch.module)?;
            Some((touch.clone(), origin(setup, module)))
        });
        let numbered = modules.iter().enumerate();
        let band = band::band(setup);
        Self {
            outputs: header.wires.iter().map(|w| (w.board, w.channel)).collect(),
            modules: numbered
                .map(|(number, module)| (module.points().len(), shown.contains(&number)))
                .collect(),
            touches: placed.collect(),
            memory: Memory {
                contacts: Vec::new(),
                frames: 0,
                warm: vec![[f64::NAN; 2]; header.wires.len()],
                driven: Driven::default(),
                hottest_mc: None,
            },
            band_db: band.ok().map(|band| [band.level_db[0], band.level_db[2]]),
            warm: Vec::new(),
            used: Vec::new(),
            totals: None,
            looked_us: [None; 2],
            shown_us: 0,
        }
    }

    /// Parts of the state that a picture at this time needs.
    #[must_use]
    pub fn wants(&self, now_us: u64) -> Wants {
        let close = now_us.saturating_sub(self.shown_us) < CLOSE_US;
        let [looked, totaled] = self
            .looked_us
            .map(|then| then.map_or(u64::MAX, |then| now_us.saturating_sub(then)));
        Wants {
            readings: close || looked >= LOOK_US,
            totals: totaled >= if close { LOOK_US } else { TOTALS_US },
        }
    }

    /// Takes in events since the last picture that no picture shows.
    pub fn pass(&mut self, events: &[Event]) {
        for event in events {
            match event {
                Event::Frame(_) => {
                    self.memory.frames += 1;
                    self.memory.contacts.clear();
                }
                Event::Contact(now) => self.memory.contacts.push(contact(now)),
                Event::Wire(now) => self.warms(now, 0),
                Event::Skin(now) => {
                    self.warms(now, 1);
                    self.memory.hottest_mc = self.memory.hottest_mc.max(Some(now.milli_c));
                }
                Event::Schedule(entry) => self.memory.driven.add(entry),
                _ => {}
            }
        }
    }

    pub(crate) const fn memory(&self) -> &Memory {
        &self.memory
    }

    pub(crate) fn recall(&mut self, memory: &Memory) {
        self.memory.clone_from(memory);
    }

    fn warms(&mut self, now: &event::Temperature, which: usize) {
        if let Some(warm) = self.memory.warm.get_mut(usize::from(now.wire)) {
            warm[which] = f64::from(now.milli_c) / 1e3;
        }
    }

    /// Picture of a moment: events since the last one, and the newest readings of all taxels.
    pub fn picture(&mut self, events: &[Event], counts: &[f32], state: State) -> Picture {
        self.pass(events);
        let now_us = state.now.as_micros();
        self.keep(&state);
        let place = |contact: &Contact| {
            let at = Point::new(contact.at_mm[0] as f32, contact.at_mm[1] as f32);
            let on_mm = state.map.shows(at).then(|| pair(state.map.apply(at)));
            Contact { on_mm, ..*contact }
        };
        let totals = self.totals.as_ref();
        let mut picture = Picture {
            now_us,
            counts: self.counts(counts),
            frames: self.memory.frames,
            contacts: self.memory.contacts.iter().map(place).collect(),
            fingers: Vec::new(),
            spheres: self.spheres(now_us),
            warm: match self.warm.is_empty() {
                true => self.memory.warm.clone(),
                false => self.warm.clone(),
            },
            used: self.used.clone(),
            hottest: totals.map(|t| [t.hottest_tissue_c, t.hottest_deep_c, t.dose.0, t.dose.1]),
            energy_j: totals.map(|totals| totals.electrical_j),
            bursts: Vec::new(),
            edges: Vec::new(),
            felt: Vec::new(),
            notes: Vec::new(),
            stopped: state.stopped,
            dropped: 0,
        };
        for event in events {
            self.add(event, &mut picture);
        }
        picture
    }

    /// Keeps the results of a look, for the pictures until the next one.
    fn keep(&mut self, state: &State) {
        let now_us = state.now.as_micros();
        self.shown_us = now_us;
        if let Some(used) = state.used() {
            self.warm = state.warm().into_iter().map(|two| two.map(short)).collect();
            self.looked_us[0] = Some(now_us);
            let rows = used.into_iter();
            self.used = rows.map(|(limit, share)| (limit, short(share))).collect();
        }
        if let Some(totals) = state.totals() {
            self.looked_us[1] = Some(now_us);
            self.totals = Some(totals);
        }
    }

    /// The newest readings of the shown modules.
    fn counts(&self, all: &[f32]) -> Vec<Option<u32>> {
        let mut rest = all;
        let mut counts = Vec::new();
        for &(taxels, is_shown) in &self.modules {
            let (own, later) = rest.split_at(taxels.min(rest.len()));
            rest = later;
            if is_shown {
                counts.extend(own.iter().map(|c| c.is_finite().then(|| c.round() as u32)));
            }
        }
        counts
    }

    /// The scene's touches at a time: x, y (mm), force (N), diameter (mm).
    fn spheres(&self, now_us: u64) -> Vec<[f64; 4]> {
        let t_s = now_us as f64 * 1e-6;
        let sphere = |(touch, [x, y]): &(Touch, [f32; 2])| {
            let at = touch.at(t_s)?;
            let (x, y) = (f64::from(*x), f64::from(*y));
            Some([at.x_mm + x, at.y_mm + y, at.force_n, at.diameter_mm])
        };
        self.touches.iter().filter_map(sphere).collect()
    }

    fn wire_of(&self, board: u8, channel: u8) -> Option<usize> {
        self.outputs.iter().position(|w| *w == (board, channel))
    }

    /// Adds an event to a picture.
    fn add(&self, event: &Event, picture: &mut Picture) {
        match event {
            Event::Schedule(entry) => {
                let wire = self.wire_of(entry.board.0, entry.channel.0);
                picture.bursts.extend(wire.map(|wire| Burst {
                    at_us: entry.at.as_micros(),
                    until_us: entry.until.as_micros(),
                    wire,
                    ticks: entry.width().get(),
                    asked: entry.requested.get(),
                    reason: entry.reason.map(|reason| reason.word()),
                }));
            }
            Event::Edge(edge) => {
                let wire = self.wire_of(edge.board, edge.channel);
                let at_us = edge.t_ns as f64 * 1e-3;
                let edges = wire.map(|wire| (at_us, wire, edge.high));
                picture.edges.extend(edges);
            }
            Event::Felt(onset) => picture.felt.push(Felt {
                at_us: onset.t_us,
                target_mm: mm(onset.target),
                inside: onset.inside,
                at_mm: onset.met.map(|met| mm(met.energy)),
                level_db: (onset.met).map_or(f64::NAN, |met| f64::from(met.level_mdb) / 1e3),
                band_db: self.band_db.filter(|_| onset.met.is_some()),
                tap: onset.met.is_some_and(|met| met.tap),
            }),
            Event::AllOff(off) => {
                let text = format!("all off: {}", off.cause);
                picture.notes.push((off.t_us, "off", text));
            }
            Event::Note(note) => {
                let text = note.text.clone();
                picture.notes.push((note.t_us, "note", text));
            }
            _ => {}
        }
    }
}

fn contact(now: &event::Contact) -> Contact {
    Contact {
        id: now.contact,
        module: now.module,
        at_mm: mm(now.place),
        on_mm: None,
        counts: f64::from(now.intensity_milli) / 1e3,
        level: now.level,
    }
}
