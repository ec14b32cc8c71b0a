//! The messages of a recording.

use palpate_core::bus::Received;
use palpate_core::codec::can::CanFrame;
use palpate_core::contact::Contact;
use palpate_core::schedule::{Entry, Reason};
use palpate_core::units::{Board, Channel, Instant, Milliamps, Ticks};

use super::described::{Described, FieldKind, Visit, decode};
use crate::i2c::Transfer;
use crate::trace::{FeltAt, event};

/// A frame on a sensor bus.
#[derive(Default)]
pub(super) struct CanMessage<'a> {
    bus: u8,
    id: u16,
    data: &'a [u8],
}

impl<'a> Described<'a> for CanMessage<'a> {
    const NAME: &'static str = "CanFrame";

    fn fields(&mut self, visit: &mut impl Visit<'a>) {
        visit.whole("bus", &mut self.bus);
        visit.whole("id", &mut self.id);
        visit.data("data", FieldKind::Bytes, &mut self.data);
    }
}

impl<'a> From<&'a Received> for CanMessage<'a> {
    fn from(received: &'a Received) -> Self {
        Self {
            bus: received.bus,
            id: received.frame.id(),
            data: received.frame.data(),
        }
    }
}

/// The frame that a message holds, at its time; `None` for a damaged message.
pub(super) fn frame(t_ns: u64, message: &[u8]) -> Option<Received> {
    let said: CanMessage<'_> = decode(message)?;
    Some(Received {
        at: Instant::from_micros(t_ns / 1000),
        bus: said.bus,
        frame: CanFrame::new(said.id, said.data)?,
    })
}

/// A message of an I2C transfer.
impl<'a> Described<'a> for &'a Transfer {
    const NAME: &'static str = "I2c";

    fn fields(&mut self, visit: &mut impl Visit<'a>) {
        let of: &'a Transfer = self;
        visit.whole("bus", &mut { of.bus });
        visit.whole("address", &mut { of.address });
        visit.truth("read", &mut { of.read });
        visit.data("data", FieldKind::Bytes, &mut of.data.as_slice());
        visit.whole("end_ns", &mut { of.end_ns });
        visit.text("error", &mut of.error.as_deref().unwrap_or_default());
    }
}

/// Readings of a module's taxels in a frame, raw counts, and their distance from the reference: packed numbers.
#[derive(Default)]
pub(super) struct TaxelCounts<'a>(pub [&'a [u8]; 4]);

impl<'a> Described<'a> for TaxelCounts<'a> {
    const NAME: &'static str = "Taxels";

    fn fields(&mut self, visit: &mut impl Visit<'a>) {
        for (name, counts) in ["x", "y", "z", "relative"].into_iter().zip(&mut self.0) {
            visit.data(name, FieldKind::Counts, counts);
        }
    }
}

impl<'a> Described<'a> for event::Frame {
    const NAME: &'static str = "Frame";

    fn fields(&mut self, visit: &mut impl Visit<'a>) {
        visit.whole("frame", &mut self.frame);
        visit.whole("in_contact", &mut self.in_contact);
        visit.whole("peak_counts", &mut self.peak_counts);
    }
}

impl<'a> Described<'a> for event::Contact {
    const NAME: &'static str = "Contact";

    fn fields(&mut self, visit: &mut impl Visit<'a>) {
        visit.whole("frame", &mut self.frame);
        visit.whole("module", &mut self.module);
        visit.whole("contact", &mut self.contact);
        visit.place(["x_mm", "y_mm"], &mut self.place);
        visit.milli("intensity", &mut self.intensity_milli);
        visit.whole("level", &mut self.level);
        visit.whole("members", &mut self.members);
    }
}

/// A contact with all of its digits, as it crosses a network; the message around it counts the frame.
impl<'a> Described<'a> for Contact {
    const NAME: &'static str = "Contact";

    fn fields(&mut self, visit: &mut impl Visit<'a>) {
        visit.whole("frame", &mut 0_u32);
        visit.whole("module", &mut self.module);
        visit.whole("contact", &mut self.id);
        visit.single("x_mm", &mut self.place.x);
        visit.single("y_mm", &mut self.place.y);
        visit.single("intensity", &mut self.intensity);
        visit.whole("level", &mut self.level);
        visit.whole("members", &mut self.members);
    }
}

impl<'a> Described<'a> for event::Truth {
    const NAME: &'static str = "Truth";

    fn fields(&mut self, visit: &mut impl Visit<'a>) {
        visit.place(["x_mm", "y_mm"], &mut self.place);
        visit.milli("force_n", &mut self.force_mn);
    }
}

/// Command to a wire's channel, beside the request; ticks of 4096 to a period.
pub(super) struct Stimulus {
    pub entry: Entry,
    pub pulses: u64,
    pub period_ns: u64,
}

impl Default for Stimulus {
    fn default() -> Self {
        let at = Instant::ZERO;
        let entry = Entry {
            at,
            board: Board(0),
            channel: Channel(0),
            on: 0,
            off: 0,
            until: at,
            requested: Ticks::ZERO,
            requested_until: at,
            current: None,
            reason: None,
        };
        let (pulses, period_ns) = (0, 0);
        Self {
            entry,
            pulses,
            period_ns,
        }
    }
}

impl<'a> Described<'a> for Stimulus {
    const NAME: &'static str = "Schedule";

    fn fields(&mut self, visit: &mut impl Visit<'a>) {
        let entry = &mut self.entry;
        let mut requested = entry.requested.get();
        let mut until_us = entry.until.as_micros();
        let mut reason = entry.reason.map_or("", |r| r.word());
        // 0 where it is `until_us`.
        let is_cut = entry.requested_until != entry.until;
        let mut asked_us = u64::from(is_cut) * entry.requested_until.as_micros();
        // 0 where the amplifier has a current of its own.
        let mut milliamps = entry.current.map_or(0, |current| current.0);
        visit.whole("board", &mut entry.board.0);
        visit.whole("channel", &mut entry.channel.0);
        visit.whole("requested", &mut requested);
        visit.whole("applied", &mut entry.width().get());
        visit.whole("on", &mut entry.on);
        visit.whole("off", &mut entry.off);
        visit.whole("until_us", &mut until_us);
        visit.text("reason", &mut reason);
        visit.whole("pulses", &mut self.pulses);
        visit.whole("period", &mut self.period_ns);
        visit.whole("requested_until_us", &mut asked_us);
        visit.whole("current_ma", &mut milliamps);
        let known = Reason::ALL.into_iter().find(|r| r.word() == reason);
        visit.require(reason.is_empty() || known.is_some());
        visit.require(asked_us == 0 || asked_us >= until_us);
        let most = requested.max(entry.on).max(entry.off);
        visit.require(most <= Ticks::PER_PERIOD);
        entry.requested = Ticks::new(requested);
        entry.until = Instant::from_micros(until_us);
        entry.requested_until = Instant::from_micros(asked_us.max(until_us));
        entry.current = (milliamps > 0).then_some(Milliamps(milliamps));
        entry.reason = known;
    }
}

/// A line of the schedule; `None` for what is no such message.
pub(super) fn stimulus(t_ns: u64, message: &[u8]) -> Option<Stimulus> {
    let mut said: Stimulus = decode(message)?;
    said.entry.at = Instant::from_micros(t_ns / 1000);
    Some(said)
}

/// Tells whether pulses and period of a line of the schedule are those that the times make; also `true` where an older
/// file has neither. `None` for what is no such message.
pub(super) fn agrees(t_ns: u64, message: &[u8]) -> Option<bool> {
    let said = stimulus(t_ns, message)?;
    Some(match said.period_ns {
        0 => said.pulses == 0,
        period_ns => said.pulses == said.entry.pulses(period_ns),
    })
}

/// A board's PRE_SCALE was set, or all of its outputs went off at once.
#[derive(Default)]
pub(super) struct BoardMessage<'a> {
    pub board: u8,
    pub pre_scale: u8,
    pub all_off: &'a str,
}

impl<'a> Described<'a> for BoardMessage<'a> {
    const NAME: &'static str = "Board";

    fn fields(&mut self, visit: &mut impl Visit<'a>) {
        visit.whole("board", &mut self.board);
        visit.whole("pre_scale", &mut self.pre_scale);
        visit.text("all_off", &mut self.all_off);
    }
}

/// An output of a wire changed.
impl<'a> Described<'a> for event::Edge {
    const NAME: &'static str = "Pin";

    fn fields(&mut self, visit: &mut impl Visit<'a>) {
        visit.truth("high", &mut self.high);
    }
}

impl<'a> Described<'a> for event::Temperature {
    const NAME: &'static str = "Temperature";

    fn fields(&mut self, visit: &mut impl Visit<'a>) {
        visit.milli("celsius", &mut self.milli_c);
    }
}

/// Sensation of a person at an onset; NaN where there is none.
impl<'a> Described<'a> for event::Felt {
    const NAME: &'static str = "Felt";

    fn fields(&mut self, visit: &mut impl Visit<'a>) {
        let (mut energy, mut amplitude) =
            (self.met.map(|m| m.energy), self.met.map(|m| m.amplitude));
        let mut level_db = self.met.map_or(f64::NAN, |m| f64::from(m.level_mdb) * 1e-3);
        let mut skin_nm = self.met.map_or(0, |m| m.skin_nm);
        let mut tap = self.met.is_some_and(|m| m.tap);
        let all = &mut self.energy;
        visit.place(["target_x_mm", "target_y_mm"], &mut self.target);
        visit.truth("inside", &mut self.inside);
        visit.truth("felt", &mut self.met.is_some_and(|m| m.is_felt()));
        visit.maybe_place(["energy_x_mm", "energy_y_mm"], &mut energy);
        visit.maybe_place(["amplitude_x_mm", "amplitude_y_mm"], &mut amplitude);
        visit.whole("energy_permille", &mut all.requested);
        visit.whole("applied_permille", &mut all.applied);
        visit.whole("felt_permille", &mut all.felt);
        visit.real("level_db", &mut level_db);
        visit.truth("tap", &mut tap);
        visit.milli("skin_um", &mut skin_nm);
        self.met = energy.zip(amplitude).map(|(energy, amplitude)| FeltAt {
            energy,
            amplitude,
            level_mdb: (level_db * 1e3).round() as i32,
            skin_nm,
            tap,
        });
    }
}

/// A joint's angle, degrees; in a recording of a run with joints.
#[derive(Default)]
pub(super) struct Angle(pub f64);

impl<'a> Described<'a> for Angle {
    const NAME: &'static str = "Joint";

    fn fields(&mut self, visit: &mut impl Visit<'a>) {
        visit.real("degrees", &mut self.0);
        visit.require(self.0.is_finite());
    }
}

/// Temperatures and current of a Peltier module; NaN where nothing is aimed at, and a current that cools is positive.
impl<'a> Described<'a> for event::Face {
    const NAME: &'static str = "Face";

    fn fields(&mut self, visit: &mut impl Visit<'a>) {
        visit.milli("celsius", &mut self.face_mc);
        visit.maybe_milli("aim_celsius", &mut self.aim_mc);
        visit.milli("sink_celsius", &mut self.sink_mc);
        visit.milli("ampere", &mut self.milliamps);
    }
}

/// A line of the log, as far as it is written: a message of Foxglove's.
#[derive(Default)]
pub(super) struct Line<'a> {
    pub timestamp: &'a [u8],
    pub level: u32,
    pub text: &'a str,
    pub name: &'a str,
}

impl<'a> Described<'a> for Line<'a> {
    const NAME: &'static str = "Log";

    fn fields(&mut self, visit: &mut impl Visit<'a>) {
        let timestamp = FieldKind::Message("google.protobuf.Timestamp");
        visit.data("timestamp", timestamp, &mut self.timestamp);
        visit.whole("level", &mut self.level);
        visit.text("message", &mut self.text);
        visit.text("name", &mut self.name);
    }
}

#[cfg(test)]
#[path = "messages_tests.rs"]
mod tests;
