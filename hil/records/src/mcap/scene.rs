//! Pictures for Foxglove: the skin's taxels as points, contacts, wires and felt places as shapes, and beside them the
//! taxels' values as numbers. Pictures come 25 times per second at most; numbers come whole.

use std::array::from_fn;
use std::io;

use super::container::Store;
use super::described::{encode, schema};
use super::foxglove::{CLOUD, SCENE, TRANSFORM, descriptor};
use super::messages::TaxelCounts;
use super::proto::{Message, pack};
use crate::readings::{ModulePlaces, TaxelFrame};
use crate::trace::{Event, FeltAt, Header, PlaceUm};

/// Least time between two pictures, microseconds.
const PICTURE_US: u64 = 40_000;
/// Gap between two modules, and between skin and display, mm.
const GAP_MM: f64 = 8.0;

type Rgba = [f64; 4];
const CONTACT: Rgba = [0.81, 0.13, 0.18, 1.0];
const AIM: Rgba = [0.6, 0.63, 0.68, 0.8];
const FELT: Rgba = [0.85, 0.45, 0.05, 1.0];

/// The topics of a module.
#[derive(Debug)]
struct Pad {
    places: Vec<PlaceUm>,
    taxels: u16,
    cloud: u16,
}

/// A wire: what drives it, where it is, and until when and how wide it is driven.
#[derive(Clone, Copy, Debug)]
struct Shown {
    output: (u8, u8),
    place: PlaceUm,
    until_us: u64,
    width: u16,
}

/// The picture in the making.
#[derive(Debug)]
pub(super) struct Scene {
    topic: u16,
    pads: Vec<Pad>,
    wires: Vec<Shown>,
    widest: u16,
    /// Contacts of the newest frame: module, identity, place.
    contacts: Vec<(u16, u32, PlaceUm)>,
    felt: Option<(PlaceUm, Option<FeltAt>)>,
    /// Time at which the next picture of the scene and of the taxels is due.
    due_us: u64,
    due_cloud_us: u64,
}

fn mm(um: i32) -> f64 {
    f64::from(um) / 1e3
}

/// A `google.protobuf.Timestamp`.
pub(super) fn stamp(t_us: u64) -> Message {
    let mut stamp = Message::default();
    stamp
        .uint(1, t_us / 1_000_000)
        .uint(2, t_us % 1_000_000 * 1000);
    stamp
}

/// Millimetres as metres.
fn vector(mm: [f64; 3]) -> Message {
    let mut vector = Message::default();
    for (field, value) in (1..).zip(mm) {
        vector.double(field, value / 1e3);
    }
    vector
}

/// Orientation without a turn.
fn upright() -> Message {
    let mut rotation = Message::default();
    rotation.double(4, 1.0);
    rotation
}

/// A cube or sphere about a place, mm.
fn shape(at: PlaceUm, z: f64, size: [f64; 3], color: Rgba) -> Message {
    let mut pose = Message::default();
    pose.inner(1, &vector([mm(at.x), mm(at.y), z]))
        .inner(2, &upright());
    let mut rgba = Message::default();
    for (field, value) in (1..).zip(color) {
        rgba.double(field, value);
    }
    let mut shape = Message::default();
    shape
        .inner(1, &pose)
        .inner(2, &vector(size))
        .inner(3, &rgba);
    shape
}

/// Shapes of one name; they replace those of this name before.
fn entity(
    update: &mut Message,
    t_us: u64,
    (frame, id): (&str, &str),
    (field, shapes): (u32, &[Message]),
) {
    let mut entity = Message::default();
    entity.inner(1, &stamp(t_us)).text(2, frame).text(3, id);
    for shape in shapes {
        entity.inner(field, shape);
    }
    update.inner(2, &entity);
}

const CUBES: u32 = 8;
const SPHERES: u32 = 9;

fn frame_id(module: usize) -> String {
    format!("module {module}")
}

/// Lowest and highest of a coordinate, mm.
fn extent(places: &[PlaceUm], pick: fn(&PlaceUm) -> i32) -> (f64, f64) {
    let all = || places.iter().map(pick);
    (mm(all().min().unwrap_or(0)), mm(all().max().unwrap_or(0)))
}

impl Scene {
    /// Makes the topics, and says where modules and display lie: side by side, the display below.
    pub fn begin(
        store: &mut impl Store,
        header: &Header,
        modules: &[ModulePlaces],
    ) -> io::Result<Self> {
        let types = descriptor();
        let cloud = store.schema(CLOUD, &types)?;
        let scene = store.schema(SCENE, &types)?;
        let transform = store.schema(TRANSFORM, &types)?;
        let counts = schema(store, TaxelCounts::default())?;
        let topic = store.channel(scene, "/scene")?;
        let frames = store.channel(transform, "/frames_of_reference")?;
        let mut pads = Vec::with_capacity(modules.len());
        let (mut right, mut lowest) = (0.0_f64, 0.0_f64);
        for (index, module) in modules.iter().enumerate() {
            pads.push(Pad {
                places: module.taxels.clone(),
                taxels: store.channel(counts, &format!("/taxels/{index}"))?,
                cloud: store.channel(cloud, &format!("/skin/{index}"))?,
            });
            let (x, y) = (
                extent(&module.taxels, |p| p.x),
                extent(&module.taxels, |p| p.y),
            );
            let left = if index == 0 { x.0 } else { right + GAP_MM };
            place(store, frames, &frame_id(index), [left - x.0, 0.0, 0.0])?;
            right = left + (x.1 - x.0);
            lowest = lowest.min(y.0);
        }
        if modules.is_empty() {
            place(store, frames, &frame_id(0), [0.0; 3])?;
        }
        let wires: Vec<_> = header.wires.iter().map(|w| w.place).collect();
        let below = lowest - 2.0 * GAP_MM - extent(&wires, |p| p.y).1;
        place(store, frames, "display", [0.0, below, 0.0])?;
        let shown = |w: &crate::trace::WireInfo| Shown {
            output: (w.board, w.channel),
            place: w.place,
            until_us: 0,
            width: 0,
        };
        Ok(Self {
            topic,
            pads,
            wires: header.wires.iter().map(shown).collect(),
            widest: 1,
            contacts: Vec::new(),
            felt: None,
            due_us: 0,
            due_cloud_us: 0,
        })
    }

    /// Takes what happened; a frame that is due brings the picture before it.
    pub fn event(&mut self, event: &Event, store: &mut impl Store) -> io::Result<()> {
        match event {
            Event::Frame(frame) => {
                if frame.t_us >= self.due_us {
                    self.due_us = frame.t_us + PICTURE_US;
                    self.draw(frame.t_us, store)?;
                }
                self.contacts.clear();
            }
            Event::Contact(now) => self.contacts.push((now.module, now.contact, now.place)),
            Event::Felt(onset) => {
                self.felt = Some((onset.target, onset.met.filter(FeltAt::is_felt)));
            }
            Event::Schedule(entry) => {
                let output = (entry.board.0, entry.channel.0);
                if let Some(wire) = self.wires.iter_mut().find(|w| w.output == output) {
                    (wire.until_us, wire.width) = (entry.until.as_micros(), entry.width().get());
                    self.widest = self.widest.max(wire.width);
                }
            }
            Event::AllOff(off) => {
                let own = self.wires.iter_mut().filter(|w| w.output.0 == off.board);
                own.for_each(|w| w.width = 0);
            }
            _ => {}
        }
        Ok(())
    }

    fn draw(&self, t_us: u64, store: &mut impl Store) -> io::Result<()> {
        let mut update = Message::default();
        for module in 0..self.pads.len().max(1) {
            let own = self.contacts.iter().filter(|c| usize::from(c.0) == module);
            let spheres: Vec<_> = own.map(|c| shape(c.2, 1.0, [2.5; 3], CONTACT)).collect();
            let (frame, id) = (frame_id(module), format!("contacts {module}"));
            entity(&mut update, t_us, (&frame, &id), (SPHERES, &spheres));
        }
        let bars = self.wires.iter().map(|wire| {
            let driven = if wire.until_us > t_us { wire.width } else { 0 };
            let part = f64::from(driven) / f64::from(self.widest);
            let color = [0.3 + 0.6 * part, 0.3 + 0.2 * part, 0.35 - 0.25 * part, 1.0];
            shape(wire.place, 0.0, [5.0, 0.8 + part, 0.8], color)
        });
        let bars: Vec<_> = bars.collect();
        entity(&mut update, t_us, ("display", "wires"), (CUBES, &bars));
        let mut spheres = Vec::new();
        if let Some((target, felt)) = self.felt {
            spheres.push(shape(target, 1.0, [1.6; 3], AIM));
            spheres.extend(felt.map(|f| shape(f.energy, 1.5, [2.5; 3], FELT)));
        }
        entity(&mut update, t_us, ("display", "felt"), (SPHERES, &spheres));
        store.message(self.topic, t_us.saturating_mul(1000), update.bytes())
    }

    /// A frame's values, and the picture of them where one is due.
    pub fn taxels(&mut self, frame: &TaxelFrame, store: &mut impl Store) -> io::Result<()> {
        let t_ns = frame.t_us.saturating_mul(1000);
        let due = self.is_cloud_due(frame.t_us);
        let mut rest = &*frame.readings;
        let mut message = Message::default();
        for (module, pad) in self.pads.iter().enumerate() {
            let Some((own, others)) = rest.split_at_checked(pad.places.len()) else {
                break;
            };
            rest = others;
            let counts: [_; 4] = from_fn(|axis| pack(own.iter().map(|r| r[axis])));
            let mut counts = TaxelCounts(counts.each_ref().map(Message::bytes));
            encode(&mut counts, &mut message);
            store.message(pad.taxels, t_ns, message.bytes())?;
            if due {
                let counts = own.iter().map(|reading| f32::from(reading[3]));
                let points = points(frame.t_us, &frame_id(module), &pad.places, counts);
                store.message(pad.cloud, t_ns, points.bytes())?;
            }
        }
        Ok(())
    }

    /// The picture of the taxels, where one is due: a count for each, module by module.
    pub fn picture(&mut self, t_us: u64, counts: &[f32], store: &mut impl Store) -> io::Result<()> {
        if !self.is_cloud_due(t_us) {
            return Ok(());
        }
        let mut rest = counts;
        for (module, pad) in self.pads.iter().enumerate() {
            let Some((own, others)) = rest.split_at_checked(pad.places.len()) else {
                break;
            };
            rest = others;
            let own = own.iter().copied();
            let points = points(t_us, &frame_id(module), &pad.places, own);
            store.message(pad.cloud, t_us.saturating_mul(1000), points.bytes())?;
        }
        Ok(())
    }

    /// Tells whether a picture of the taxels is due, and counts it as made.
    const fn is_cloud_due(&mut self, t_us: u64) -> bool {
        let due = t_us >= self.due_cloud_us;
        if due {
            self.due_cloud_us = t_us + PICTURE_US;
        }
        due
    }
}

/// Places a frame of reference in the one of the whole recording.
fn place(store: &mut impl Store, topic: u16, child: &str, at: [f64; 3]) -> io::Result<()> {
    let mut transform = Message::default();
    transform
        .inner(1, &Message::default())
        .text(2, "palpate")
        .text(3, child)
        .inner(4, &vector(at))
        .inner(5, &upright());
    store.message(topic, 0, transform.bytes())
}

/// Taxels as points: x, y, z in metres and counts, 32-bit floating point.
fn points(
    t_us: u64,
    frame: &str,
    places: &[PlaceUm],
    counts: impl Iterator<Item = f32>,
) -> Message {
    const FLOAT32: u32 = 7;
    const NAMES: [&str; 4] = ["x", "y", "z", "counts"];
    let mut pose = Message::default();
    pose.inner(1, &Message::default()).inner(2, &upright());
    let mut cloud = Message::default();
    cloud
        .inner(1, &stamp(t_us))
        .text(2, frame)
        .inner(3, &pose)
        .fixed32(4, 4 * NAMES.len() as u32);
    for (place, name) in (0..).zip(NAMES) {
        let mut field = Message::default();
        field.text(1, name).fixed32(2, 4 * place).uint(3, FLOAT32);
        cloud.inner(5, &field);
    }
    let mut data = Vec::with_capacity(16 * places.len());
    for (place, count) in places.iter().zip(counts) {
        let metres = |um| (mm(um) / 1e3) as f32;
        for value in [metres(place.x), metres(place.y), 0.0, count] {
            data.extend(value.to_le_bytes());
        }
    }
    cloud.data(6, &data);
    cloud
}
