//! A run, or a bus, as an [MCAP](https://mcap.dev) file: what happened and the raw frames behind it, each
//! message with its schema, so that Foxglove, PlotJuggler and rerun need nothing from us.
//!
//! Times are nanoseconds since the start of the run (of a recorded bus: since 1970). Topics of a wire carry
//! its number, and fields are scalars: a plot of one of them is one curve.

mod container;
mod described;
mod fields;
mod foxglove;
mod messages;
pub mod proto;
mod read;
mod scene;
mod schema;
mod told;
mod topics;

pub use container::{Attachment, Container, Store};
pub use described::{
    Described, FieldKind, MessageField, MessageSchema, Visit, decode, descriptor_set, encode,
    encoded, full_name,
};
pub use foxglove::LOG;
pub use read::{McapReader, Read, Tear, Unreadable, read};
pub use told::Told;

use std::collections::BTreeMap;
use std::io::{self, Write};

use palpate_core::bus::Received;

use crate::i2c::Transfer;
use crate::readings::{ModulePlaces, Readings, TaxelFrame};
use crate::trace::{self, Event, Header, Trace};
use described::schema;
use messages::{CanMessage, Line};
use proto::Message;
use scene::stamp;
use schema::Level;
use topics::RunTopics;

/// Version of the topics and what they say; grows when one changes its meaning.
pub const VERSION: u32 = 1;

/// The profile in the file's header, and the name of the metadata record with the versions.
pub const PROFILE: &str = "palpate";

/// Traffic on the buses of a run, in the order of time, and the readings decoded from it.
#[derive(Clone, Copy, Debug, Default)]
pub struct BusTraffic<'a> {
    /// Readings of taxels; empty where only their frames are recorded.
    pub taxels: &'a [TaxelFrame],
    /// Frames on the sensor buses, as the host saw them.
    pub can: &'a [Received],
    /// Messages on the actuator buses.
    pub i2c: &'a [Transfer],
}

/// Writes a whole run, with the readings that it kept.
///
/// # Errors
/// The writer's error.
pub fn write_mcap(
    (trace, readings): (&Trace, Option<&Readings>),
    traffic: BusTraffic<'_>,
    attachments: &[Attachment],
    out: &mut dyn Write,
) -> io::Result<()> {
    let modules = readings.map_or(&[][..], Readings::modules);
    let taxels = readings.map_or(&[][..], Readings::frames);
    let traffic = BusTraffic { taxels, ..traffic };
    let mut recording = McapRecording::of_run(&trace.header, modules, attachments, out)?;
    recording.piece(&trace.events, traffic)?;
    recording.finish().map(drop)
}

/// A recording that grows.
#[derive(Debug)]
pub struct Recording<S> {
    store: S,
    can: u16,
    run: Option<RunTopics>,
    /// The message in the making: the same memory for all.
    message: Message,
}

/// A recording that grows in a file.
pub type McapRecording<W> = Recording<Container<W>>;

impl<W: Write> McapRecording<W> {
    /// Begins a recording of a run: versions and digests, the files it goes back to, schemas and topics. Modules are
    /// those whose readings will come.
    ///
    /// # Errors
    /// The writer's error.
    pub fn of_run(
        header: &Header,
        modules: &[ModulePlaces],
        attachments: &[Attachment],
        out: W,
    ) -> io::Result<Self> {
        let mut facts = vec![
            ("trace_version", trace::VERSION.to_string()),
            ("source", header.source.word().into()),
            ("scene", header.scene.clone()),
            ("bench", header.bench.clone()),
            ("seed", header.seed.to_string()),
            ("scene_digest", header.scene_digest.clone()),
            ("limits_digest", header.limits_digest.clone()),
            ("illusion", header.illusion.clone()),
            ("pre_scale", header.pre_scale.get().to_string()),
            ("period_ns", header.pre_scale.period_ns().to_string()),
            ("tau_d_us", header.tau_d_us.to_string()),
            ("soa_us", header.soa_us.to_string()),
        ];
        let banner = header.source.banner();
        facts.extend(banner.map(|text| ("banner", text.to_owned())));
        let mut recording = Self::begin(&facts, attachments, out)?;
        recording.run = Some(RunTopics::add(&mut recording.store, header, modules)?);
        Ok(recording)
    }

    /// Begins a recording of sensor buses alone: bus n is the n-th of these interfaces.
    ///
    /// # Errors
    /// The writer's error.
    pub fn of_buses(interfaces: &[String], out: W) -> io::Result<Self> {
        let facts = [
            ("source", "real".into()),
            ("interfaces", interfaces.join(",")),
        ];
        Self::begin(&facts, &[], out)
    }

    fn begin(facts: &[(&str, String)], attachments: &[Attachment], out: W) -> io::Result<Self> {
        let library = concat!("palpate ", env!("CARGO_PKG_VERSION"));
        let mut container = Container::begin(out, PROFILE, library)?;
        let mut metadata = BTreeMap::from([("version".to_owned(), VERSION.to_string())]);
        metadata.extend(facts.iter().map(|(k, v)| ((*k).to_owned(), v.clone())));
        container.metadata(PROFILE, &metadata)?;
        attachments.iter().try_for_each(|a| container.attach(a))?;
        Self::empty(container)
    }

    /// Hands over what is there: whatever comes, a reader finds it.
    ///
    /// # Errors
    /// The writer's error.
    pub fn flush(&mut self) -> io::Result<()> {
        self.store.flush()
    }

    /// Writer of the recording.
    pub const fn get_mut(&mut self) -> &mut W {
        self.store.get_mut()
    }

    /// Closes the file with its summary.
    ///
    /// # Errors
    /// The writer's error.
    pub fn finish(self) -> io::Result<W> {
        self.store.finish()
    }
}

impl<S: Store> Recording<S> {
    fn empty(mut store: S) -> io::Result<Self> {
        let frame = schema(&mut store, CanMessage::default())?;
        let can = store.channel(frame, "/can")?;
        Ok(Self {
            store,
            can,
            run: None,
            message: Message::default(),
        })
    }

    /// Begins a recording of a run in a place of any kind. Modules are those whose readings will come.
    ///
    /// # Errors
    /// The place's error.
    pub fn of_run_in(store: S, header: &Header, modules: &[ModulePlaces]) -> io::Result<Self> {
        let mut recording = Self::empty(store)?;
        recording.run = Some(RunTopics::add(&mut recording.store, header, modules)?);
        Ok(recording)
    }

    /// Place of the recording.
    pub const fn store_mut(&mut self) -> &mut S {
        &mut self.store
    }

    /// Appends what happened since the last piece, merged by time.
    ///
    /// # Errors
    /// The writer's error.
    pub fn piece(&mut self, events: &[Event], traffic: BusTraffic<'_>) -> io::Result<()> {
        let (mut can, mut i2c) = (traffic.can.iter().peekable(), traffic.i2c.iter().peekable());
        let mut taxels = traffic.taxels;
        let at = |r: &Received| r.at.as_micros().saturating_mul(1000);
        for event in events {
            let now = event.t_ns();
            while let Some(received) = can.next_if(|r| at(r) <= now) {
                self.frame(received)?;
            }
            while let Some(transfer) = i2c.next_if(|t| t.start_ns <= now) {
                self.transfer(transfer)?;
            }
            self.event(event)?;
            while let Some((frame, later)) = taxels.split_first().filter(|f| f.0.t_us * 1000 <= now)
            {
                taxels = later;
                if let Some(run) = &mut self.run {
                    run.scene.taxels(frame, &mut self.store)?;
                }
            }
        }
        for received in can {
            while let Some(transfer) = i2c.next_if(|t| t.start_ns <= at(received)) {
                self.transfer(transfer)?;
            }
            self.frame(received)?;
        }
        i2c.try_for_each(|transfer| self.transfer(transfer))
    }

    /// Adds the picture of the skin, where one is due: a count for each taxel, module by module. A run that is recorded
    /// with its readings needs no such call.
    ///
    /// # Errors
    /// The writer's error.
    pub fn picture(&mut self, t_us: u64, counts: &[f32]) -> io::Result<()> {
        match &mut self.run {
            Some(run) => run.scene.picture(t_us, counts, &mut self.store),
            None => Ok(()),
        }
    }

    /// Writes the message in the making.
    fn send(&mut self, channel: u16, t_ns: u64) -> io::Result<()> {
        self.store.message(channel, t_ns, self.message.bytes())
    }

    fn frame(&mut self, received: &Received) -> io::Result<()> {
        encode(&mut CanMessage::from(received), &mut self.message);
        let t_ns = received.at.as_micros().saturating_mul(1000);
        self.send(self.can, t_ns)
    }

    fn transfer(&mut self, transfer: &Transfer) -> io::Result<()> {
        let Some(channel) = self.run.as_ref().map(|r| r.i2c) else {
            return Ok(());
        };
        encode(&mut { transfer }, &mut self.message);
        self.send(channel, transfer.start_ns)
    }

    fn log(&mut self, t_ns: u64, level: Level, name: &str, text: &str) -> io::Result<()> {
        let Some(channel) = self.run.as_ref().map(|r| r.log) else {
            return Ok(());
        };
        let timestamp = stamp(t_ns / 1000);
        let mut line = Line {
            timestamp: timestamp.bytes(),
            level: level as u32,
            text,
            name,
        };
        encode(&mut line, &mut self.message);
        self.send(channel, t_ns)
    }

    fn event(&mut self, event: &Event) -> io::Result<()> {
        let Some(run) = &mut self.run else {
            return Ok(());
        };
        run.scene.event(event, &mut self.store)?;
        if let Some(channel) = run.write(event, &mut self.message) {
            self.send(channel, event.t_ns())?;
        }
        self.log_event(event)
    }

    /// Logs the part of an event that is worth a line.
    fn log_event(&mut self, event: &Event) -> io::Result<()> {
        let t_ns = event.t_ns();
        match event {
            Event::Note(note) => self.log(t_ns, Level::Info, "note", &note.text),
            Event::Latent(window) => {
                let text = crate::words::texture(window);
                self.log(t_ns, Level::Info, "texture", &text)
            }
            Event::AllOff(off) => {
                let text = format!("board {}: all off: {}", off.board, off.cause);
                self.log(t_ns, Level::Info, "boards", &text)
            }
            Event::Schedule(entry) => match entry.reason {
                Some(reason) => {
                    let text = format!(
                        "board {} channel {}: {} of {} ticks: {}",
                        entry.board.0,
                        entry.channel.0,
                        entry.width().get(),
                        entry.requested.get(),
                        reason.word()
                    );
                    self.log(t_ns, Level::Warning, "limiter", &text)
                }
                None => Ok(()),
            },
            _ => Ok(()),
        }
    }
}

#[cfg(test)]
mod tests;
