//! The topics of a run, and how an event becomes the message of one of them.

use std::io;

use super::container::Store;
use super::described::{Described, encode, schema};
use super::foxglove::{self, LOG};
use super::messages::{Angle, BoardMessage, Stimulus};
use super::proto::Message;
use super::scene::Scene;
use crate::i2c::Transfer;
use crate::readings::ModulePlaces;
use crate::trace::{Event, Header, event};

/// Topics of a wire.
#[derive(Clone, Copy, Debug)]
pub(super) struct WireTopics {
    pub schedule: u16,
    pub pin: u16,
    pub wire: u16,
    pub skin: u16,
}

/// Topics of a run.
#[derive(Debug)]
pub(super) struct RunTopics {
    pub frames: u16,
    pub contacts: u16,
    pub truth: u16,
    pub boards: u16,
    pub felt: u16,
    pub i2c: u16,
    pub log: u16,
    pub wires: Vec<WireTopics>,
    /// Topic of each joint.
    pub joints: Vec<u16>,
    /// Topic of a Peltier module.
    pub face: Option<u16>,
    pub scene: Scene,
    /// PWM period of all boards, nanoseconds.
    pub period_ns: u64,
    /// Board and channel of each wire.
    pub outputs: Vec<(u8, u8)>,
}

impl RunTopics {
    /// Adds the topics of a run and their schemas to a recording. Modules are those whose readings will come.
    pub fn add(
        store: &mut impl Store,
        header: &Header,
        modules: &[ModulePlaces],
    ) -> io::Result<Self> {
        let frame = schema(store, event::Frame::default())?;
        let contact = schema(store, event::Contact::default())?;
        let truth = schema(store, event::Truth::default())?;
        let stimulus = schema(store, Stimulus::default())?;
        let board = schema(store, BoardMessage::default())?;
        let pin = schema(store, event::Edge::default())?;
        let celsius = schema(store, event::Temperature::default())?;
        let felt = schema(store, event::Felt::default())?;
        let i2c = schema(store, &Transfer::default())?;
        let log = store.schema(LOG, &foxglove::descriptor())?;
        let scene = Scene::begin(store, header, modules)?;
        let mut run = Self {
            frames: store.channel(frame, "/frames")?,
            contacts: store.channel(contact, "/contacts")?,
            truth: store.channel(truth, "/truth")?,
            boards: store.channel(board, "/boards")?,
            felt: store.channel(felt, "/felt")?,
            i2c: store.channel(i2c, "/i2c")?,
            log: 0,
            wires: Vec::new(),
            joints: Vec::new(),
            face: None,
            scene,
            period_ns: header.pre_scale.period_ns(),
            outputs: header.wires.iter().map(|w| (w.board, w.channel)).collect(),
        };
        for wire in 0..header.wires.len() {
            let mut topic = |schema, what| store.channel(schema, &format!("/wire/{wire}/{what}"));
            run.wires.push(WireTopics {
                schedule: topic(stimulus, "schedule")?,
                pin: topic(pin, "pin")?,
                wire: topic(celsius, "temperature")?,
                skin: topic(celsius, "skin")?,
            });
        }
        run.log = store.channel(log, "/events")?;
        if !header.joints.is_empty() {
            let id = schema(store, Angle::default())?;
            for name in &header.joints {
                run.joints
                    .push(store.channel(id, &format!("/joints/{name}"))?);
            }
        }
        if header.warmth {
            let id = schema(store, event::Face::default())?;
            run.face = Some(store.channel(id, "/face")?);
        }
        Ok(run)
    }

    fn of_output(&self, board: u8, channel: u8) -> Option<WireTopics> {
        let wire = self.outputs.iter().position(|o| *o == (board, channel));
        wire.map(|w| self.wires[w])
    }

    /// Writes the message of an event; returns its topic.
    pub fn write(&self, event: &Event, message: &mut Message) -> Option<u16> {
        // Every variant has its place here: a new one does not compile until it is recorded.
        match event {
            Event::Frame(e) => put(*e, message, self.frames),
            Event::Contact(e) => put(*e, message, self.contacts),
            Event::Truth(e) => put(*e, message, self.truth),
            Event::Joint(e) => {
                let angle = Angle(f64::from(e.milli_deg) / 1e3);
                put(angle, message, *self.joints.get(usize::from(e.joint))?)
            }
            Event::Schedule(entry) => {
                let stimulus = Stimulus {
                    entry: *entry,
                    pulses: entry.pulses(self.period_ns),
                    period_ns: self.period_ns,
                };
                let wire = self.of_output(entry.board.0, entry.channel.0)?;
                put(stimulus, message, wire.schedule)
            }
            Event::PreScale(e) => {
                let said = BoardMessage {
                    board: e.board,
                    pre_scale: e.pre_scale,
                    all_off: "",
                };
                put(said, message, self.boards)
            }
            Event::AllOff(e) => {
                let said = BoardMessage {
                    board: e.board,
                    pre_scale: 0,
                    all_off: e.cause,
                };
                put(said, message, self.boards)
            }
            Event::Edge(e) => put(*e, message, self.of_output(e.board, e.channel)?.pin),
            Event::Felt(e) => put(*e, message, self.felt),
            Event::Wire(e) => put(*e, message, self.wires.get(usize::from(e.wire))?.wire),
            Event::Skin(e) => put(*e, message, self.wires.get(usize::from(e.wire))?.skin),
            Event::Face(e) => put(*e, message, self.face?),
            Event::Latent(_) | Event::Note(_) => None,
        }
    }
}

fn put<'a>(mut of: impl Described<'a>, message: &mut Message, topic: u16) -> Option<u16> {
    encode(&mut of, message);
    Some(topic)
}
