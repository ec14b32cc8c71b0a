//! The topics of a run, and how an event becomes the message of one of them.

use super::described::{Described, encode};
use super::messages::{Angle, BoardMessage, Stimulus};
use super::proto::Message;
use super::scene::Scene;
use crate::trace::Event;

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
