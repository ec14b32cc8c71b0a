//! The topics of a run, and how an event becomes the message of one of them.

use super::proto::Message;
use super::scene::{Scene, mm};
use crate::trace::{Event, PlaceUm, event};

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
    /// Of each joint.
    pub joints: Vec<u16>,
    /// Of a Peltier module.
    pub face: Option<u16>,
    pub scene: Scene,
    /// PWM period of all boards, nanoseconds.
    pub period_ns: u64,
    /// Board and channel of each wire.
    pub outputs: Vec<(u8, u8)>,
}

impl RunTopics {
    pub fn of_output(&self, board: u8, channel: u8) -> Option<WireTopics> {
        let wire = self.outputs.iter().position(|o| *o == (board, channel));
        wire.map(|w| self.wires[w])
    }

    pub fn of_wire(&self, wire: u16) -> Option<WireTopics> {
        self.wires.get(usize::from(wire)).copied()
    }

    /// Fills in what the sensor end saw; the topic it goes to.
    pub fn sensed(&self, event: &Event, message: &mut Message) -> Option<u16> {
        match event {
            Event::Frame(event::Frame {
                frame,
                in_contact,
                peak_counts,
                ..
            }) => {
                message
                    .uint(1, *frame)
                    .uint(2, *in_contact)
                    .uint(3, *peak_counts);
                Some(self.frames)
            }
            Event::Contact(event::Contact {
                frame,
                module,
                contact,
                place,
                intensity_milli,
                level,
                members,
                ..
            }) => {
                message
                    .uint(1, *frame)
                    .uint(2, *module)
                    .uint(3, *contact)
                    .double(4, mm(place.x))
                    .double(5, mm(place.y))
                    .double(6, f64::from(*intensity_milli) / 1e3)
                    .uint(7, *level)
                    .uint(8, *members);
                Some(self.contacts)
            }
            Event::Truth(event::Truth {
                place, force_mn, ..
            }) => {
                message
                    .double(1, mm(place.x))
                    .double(2, mm(place.y))
                    .double(3, f64::from(*force_mn) / 1e3);
                Some(self.truth)
            }
            Event::Joint(event::Joint {
                joint, milli_deg, ..
            }) => {
                message.double(1, f64::from(*milli_deg) / 1e3);
                self.joints.get(usize::from(*joint)).copied()
            }
            _ => None,
        }
    }

    /// The same of what the boards were told.
    pub fn told(&self, event: &Event, message: &mut Message) -> Option<u16> {
        match event {
            Event::Schedule(entry) => {
                let cut = entry.requested_until != entry.until;
                message
                    .uint(1, entry.board.0)
                    .uint(2, entry.channel.0)
                    .uint(3, entry.requested.get())
                    .uint(4, entry.width().get())
                    .uint(5, entry.on)
                    .uint(6, entry.off)
                    .uint(7, entry.until.as_micros())
                    .text(8, entry.reason.map_or("", |r| r.word()))
                    .uint(9, entry.pulses(self.period_ns))
                    .uint(10, self.period_ns)
                    .uint(11, u64::from(cut) * entry.requested_until.as_micros())
                    .uint(12, entry.current.map_or(0, |current| current.0));
                self.of_output(entry.board.0, entry.channel.0)
                    .map(|w| w.schedule)
            }
            Event::PreScale(event::PreScale {
                board, pre_scale, ..
            }) => {
                message.uint(1, *board).uint(2, *pre_scale);
                Some(self.boards)
            }
            Event::AllOff(event::AllOff { board, cause, .. }) => {
                message.uint(1, *board).text(3, cause);
                Some(self.boards)
            }
            _ => None,
        }
    }

    /// The same of what came of it.
    pub fn came(&self, event: &Event, message: &mut Message) -> Option<u16> {
        match event {
            Event::Edge(event::Edge {
                board,
                channel,
                high,
                ..
            }) => {
                message.uint(1, *high);
                self.of_output(*board, *channel).map(|w| w.pin)
            }
            Event::Felt(event::Felt {
                target,
                inside,
                met,
                energy: all,
                ..
            }) => {
                let place =
                    |p: Option<PlaceUm>| p.map_or((f64::NAN, f64::NAN), |p| (mm(p.x), mm(p.y)));
                let energy = place(met.map(|m| m.energy));
                let amplitude = place(met.map(|m| m.amplitude));
                message
                    .double(1, mm(target.x))
                    .double(2, mm(target.y))
                    .uint(3, *inside)
                    .uint(4, met.is_some_and(|m| m.is_felt()))
                    .double(5, energy.0)
                    .double(6, energy.1)
                    .double(7, amplitude.0)
                    .double(8, amplitude.1)
                    .uint(9, all.requested)
                    .uint(10, all.applied)
                    .uint(11, all.felt)
                    .double(12, met.map_or(f64::NAN, |m| f64::from(m.level_mdb) * 1e-3))
                    .uint(13, met.is_some_and(|m| m.tap));
                Some(self.felt)
            }
            Event::Wire(event::Temperature { wire, milli_c, .. }) => {
                message.double(1, f64::from(*milli_c) / 1e3);
                self.of_wire(*wire).map(|w| w.wire)
            }
            Event::Skin(event::Temperature { wire, milli_c, .. }) => {
                message.double(1, f64::from(*milli_c) / 1e3);
                self.of_wire(*wire).map(|w| w.skin)
            }
            Event::Face(event::Face {
                face_mc,
                aim_mc,
                sink_mc,
                milliamps,
                ..
            }) => {
                message
                    .double(1, f64::from(*face_mc) / 1e3)
                    .double(2, aim_mc.map_or(f64::NAN, |mc| f64::from(mc) / 1e3))
                    .double(3, f64::from(*sink_mc) / 1e3)
                    .double(4, f64::from(*milliamps) / 1e3);
                self.face
            }
            _ => None,
        }
    }
}
