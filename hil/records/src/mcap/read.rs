//! Reading of the sensor buses' part of a recording, as far as it is whole. A file that was cut short or is damaged
//! gives what can be had, with the offset where that ends. A file of another version is refused by name.

mod run;

use std::collections::{BTreeMap, VecDeque};
use std::io::{self, Read as _};

use palpate_core::bus::Received;

use super::container::{MAGIC, op};
use super::described::{decode, full_name};
use super::fields::{Cursor, attachment, chunk_head, metadata};
use super::messages::{self, Angle, CanMessage, Stimulus};
use super::told::Topic;
use super::{PROFILE, VERSION};
use run::Waiting;

/// Content of a file, as far as it could be read.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Read {
    /// Versions, digests and names, as the file's metadata has them.
    pub metadata: BTreeMap<String, String>,
    /// Frames on the sensor buses, in the order of the file.
    pub frames: Vec<Received>,
    /// Angles of joints by name: nanoseconds and degrees, in the order of the file.
    pub joints: BTreeMap<String, Vec<(u64, f64)>>,
    /// Messages of all topics.
    pub messages: u64,
    /// Names and contents of the attached files.
    pub attachments: Vec<(String, Vec<u8>)>,
    /// Damages of the file; a chunk whose checksum fails is left out and the rest is read.
    pub damages: Vec<Tear>,
    /// Time of the last whole message, nanoseconds.
    pub last_ns: u64,
}

/// A place where the file is not what it should be.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("byte {offset}: {what}")]
pub struct Tear {
    /// Byte of the record that is damaged, or where the file ends.
    pub offset: u64,
    /// Kind of the damage.
    pub what: &'static str,
}

/// Refusal of a file: what was expected and what was found.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Unreadable {
    /// Content that was expected.
    pub expected: String,
    /// Content that was found, with its place.
    pub found: String,
}

fn unreadable(expected: &str, found: impl Into<String>) -> Unreadable {
    Unreadable {
        expected: expected.into(),
        found: found.into(),
    }
}

/// Longest record, bytes: a chunk of ours has a few MiB, and one of another program seldom more.
const MOST_RECORD: u64 = 16 << 20;
/// Most bytes of attached files that are kept, and most damages that are told one by one.
const MOST_ATTACHED: usize = 4 << 20;
const MOST_DAMAGES: usize = 1000;
/// Most angles of joints that are held, of all joints.
const MOST_ANGLES: usize = 1 << 20;

/// Reads a recording of ours from memory.
///
/// # Errors
/// [`Unreadable`] for what is no MCAP file, is compressed, is of another version or holds no sensor bus.
pub fn read(bytes: &[u8]) -> Result<Read, Unreadable> {
    let mut reader = McapReader::new(bytes)?;
    let mut frames = Vec::new();
    while let Some(frame) = reader.advance()? {
        frames.push(frame);
    }
    Ok(Read {
        frames,
        ..reader.into_read()?
    })
}

/// A recording of ours that is read record by record: memory holds one chunk of it.
#[derive(Debug)]
pub struct McapReader<R> {
    input: Counted<R>,
    record: Vec<u8>,
    contents: Contents,
    ended: bool,
}

impl<R: io::Read> McapReader<R> {
    /// Begins to read.
    ///
    /// # Errors
    /// [`Unreadable`] for what is no MCAP file.
    pub fn new(input: R) -> Result<Self, Unreadable> {
        let mut input = Counted { input, offset: 0 };
        let mut record = Vec::new();
        if !input.fill(&mut record, MAGIC.len() as u64)? || record != MAGIC {
            let found = format!("byte 0: {}", record.escape_ascii());
            return Err(unreadable("an MCAP file", found));
        }
        Ok(Self {
            input,
            record,
            contents: Contents::default(),
            ended: false,
        })
    }

    /// The next frame on a sensor bus, in the order of the file; none at its end.
    ///
    /// # Errors
    /// The errors of [`read`], and a record of more than 16 MiB.
    pub fn advance(&mut self) -> Result<Option<Received>, Unreadable> {
        loop {
            if let Some(frame) = self.contents.frames.pop_front() {
                return Ok(Some(frame));
            }
            if self.ended {
                return Ok(None);
            }
            self.step()?;
        }
    }

    /// Reads one record.
    fn step(&mut self) -> Result<(), Unreadable> {
        let Self {
            input,
            record,
            contents,
            ended,
        } = self;
        let here = input.offset;
        let head = input.fill(record, 9)?;
        let (kind, length) = match record.split_first() {
            Some((kind, length)) if head => {
                let length = length.try_into().map_or(u64::MAX, u64::from_le_bytes);
                (*kind, length)
            }
            _ => {
                contents.damage(input.offset, "the file is cut short here");
                *ended = true;
                return Ok(());
            }
        };
        if matches!(kind, op::DATA_END | op::FOOTER) {
            // The summary says nothing that was not said before; but it tells whether the end is there.
            if !input.ends_with(&MAGIC)? {
                contents.damage(input.offset, "the end of the summary is missing");
            }
            *ended = true;
            return Ok(());
        }
        if kind == 0 {
            contents.damage(here, "no record begins here");
            *ended = true;
            return Ok(());
        }
        let whole = input.fill(record, length.min(MOST_RECORD))?;
        if whole && length > MOST_RECORD {
            let expected = format!("records of at most {MOST_RECORD} bytes");
            return Err(unreadable(&expected, format!("byte {here}: {length}")));
        }
        if !whole {
            if kind == op::CHUNK {
                contents.torn_chunk(record, here);
            }
            contents.damage(input.offset, "the file is cut short here");
            *ended = true;
            return Ok(());
        }
        contents.top(kind, record, here)
    }

    /// Content of the file beside frames, as far as it was read.
    ///
    /// # Errors
    /// [`Unreadable`] where no recording of ours begins.
    pub fn into_read(self) -> Result<Read, Unreadable> {
        self.contents.finish()
    }

    /// The versions, digests and names that were read so far.
    #[must_use]
    pub const fn metadata(&self) -> &BTreeMap<String, String> {
        &self.contents.read.metadata
    }
}

/// A stream that knows how far it was read.
#[derive(Debug)]
struct Counted<R> {
    input: R,
    offset: u64,
}

impl<R: io::Read> Counted<R> {
    /// Reads `length` bytes in place of those in `record`; returns `false` where the stream ends before.
    fn fill(&mut self, record: &mut Vec<u8>, length: u64) -> Result<bool, Unreadable> {
        record.clear();
        let read = self.input.by_ref().take(length).read_to_end(record);
        let read = read.map_err(|e| unreadable("a readable file", e.to_string()))? as u64;
        self.offset += read;
        Ok(read == length)
    }

    /// Reads the rest; returns whether it ends with `end`.
    fn ends_with(&mut self, end: &[u8]) -> Result<bool, Unreadable> {
        let (mut piece, mut tail) = (Vec::new(), Vec::new());
        loop {
            let whole = self.fill(&mut piece, 1 << 16)?;
            tail.extend_from_slice(&piece);
            let spare = tail.len().saturating_sub(end.len());
            tail.drain(..spare);
            if !whole {
                return Ok(tail == end);
            }
        }
    }
}

/// Kind of a message, as far as messages are looked at.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Content {
    /// A frame on a sensor bus.
    Frame,
    /// A line of the schedule.
    Entry,
    /// The angle of a joint.
    Angle,
    Other,
}

/// Content read so far, and the state of the reader.
#[derive(Clone, Debug, Default)]
struct Contents {
    read: Read,
    /// Kinds of messages by the number of their schema.
    schemas: BTreeMap<u16, Content>,
    /// Channels by number: the prefix of the topic, and the kind of its messages.
    channels: BTreeMap<u16, (String, Content)>,
    versioned: bool,
    /// Bytes of the attachments that are kept.
    attached: usize,
    /// Angles of joints that are held.
    angles: usize,
    /// Frames of the newest chunk.
    frames: VecDeque<Received>,
    /// Topics of the run by channel, and messages of the newest chunk, where the run is wanted in place of its frames.
    run: Option<Waiting>,
}

impl Contents {
    fn damage(&mut self, offset: u64, what: &'static str) {
        if self.read.damages.len() < MOST_DAMAGES {
            self.read.damages.push(Tear { offset, what });
        }
    }

    fn finish(self) -> Result<Read, Unreadable> {
        const EXPECTED: &str = "a recording of hil, with the topic /can";
        if !self.versioned {
            let topics: Vec<_> = self.channels.into_values().map(|c| c.0).collect();
            let found = match (self.read.damages.first(), topics.as_slice()) {
                (Some(damage), []) => damage.to_string(),
                (_, topics) => format!("the topics {}", topics.join(", ")),
            };
            return Err(unreadable(EXPECTED, found));
        }
        Ok(self.read)
    }

    /// Holds a joint's angle, if there is room; `None` for what is no such message.
    fn angle(&mut self, channel: u16, t_ns: u64, message: &[u8]) -> Option<bool> {
        let Angle(deg) = decode(message)?;
        let topic = &self.channels.get(&channel)?.0;
        let name = topic.strip_prefix("/joints/")?.to_owned();
        if self.angles == MOST_ANGLES {
            return Some(false);
        }
        self.angles += 1;
        self.read.joints.entry(name).or_default().push((t_ns, deg));
        Some(true)
    }

    /// A record outside of chunks.
    fn top(&mut self, kind: u8, record: &[u8], here: u64) -> Result<(), Unreadable> {
        match kind {
            op::METADATA => {
                let Some(metadata) = metadata(record) else {
                    self.damage(here, "damaged metadata");
                    return Ok(());
                };
                if metadata.0 == PROFILE {
                    let version = metadata.1.get("version").map_or("none", |v| v);
                    if version != VERSION.to_string() {
                        return Err(unreadable(
                            &format!("a recording of version {VERSION}"),
                            format!(
                                "version {version}, written by another hil; record it again or use that one"
                            ),
                        ));
                    }
                    self.versioned = true;
                    self.read.metadata = metadata.1;
                }
            }
            op::ATTACHMENT => match attachment(record) {
                Some(file) if self.attached + file.1.len() <= MOST_ATTACHED => {
                    self.attached += file.1.len();
                    self.read.attachments.push(file);
                }
                Some(_) => self.damage(here, "attachments of more than 4 MiB are left out"),
                None => self.damage(here, "damaged attachment"),
            },
            op::CHUNK => {
                let Some((head, rest)) = chunk_head(record) else {
                    self.damage(here, "damaged head of a chunk");
                    return Ok(());
                };
                if !head.compression.is_empty() {
                    return Err(unreadable(
                        "chunks without compression (`mcap compress --compression none` makes them)",
                        format!("byte {here}: {}", head.compression),
                    ));
                }
                let records = usize::try_from(head.size).ok().and_then(|n| rest.get(..n));
                match records {
                    Some(records) if head.crc == 0 || crc32fast::hash(records) == head.crc => {
                        if !self.records(records, here) {
                            let what = "the chunk that begins here ends in the middle of a record";
                            self.damage(here, what);
                        }
                    }
                    _ => self.damage(here, "the chunk that begins here fails its checksum"),
                }
            }
            _ => self.content(kind, record, here),
        }
        Ok(())
    }

    /// Reads the records of a chunk that the file's end cuts short: its
    /// checksum cannot be asked, its records are whole or not there.
    fn torn_chunk(&mut self, rest: &[u8], here: u64) {
        let head = chunk_head(rest);
        if let Some((_, records)) = head.filter(|(head, _)| head.compression.is_empty()) {
            self.records(records, here);
        }
    }

    /// The records of a chunk; false where they end in the middle of one.
    fn records(&mut self, records: &[u8], here: u64) -> bool {
        let mut inside = Cursor(records);
        while !inside.0.is_empty() {
            let Some((kind, record)) = inside.record() else {
                return false;
            };
            self.content(kind, record, here);
        }
        true
    }

    /// A record that may lie in a chunk.
    fn content(&mut self, kind: u8, record: &[u8], here: u64) {
        let mut cursor = Cursor(record);
        let mut trouble = None;
        let mut parse = || match kind {
            op::SCHEMA => {
                let id = cursor.u16()?;
                let name = cursor.text()?;
                let content = match name {
                    name if name == full_name::<CanMessage<'_>>() => Content::Frame,
                    name if name == full_name::<Stimulus>() => Content::Entry,
                    name if name == full_name::<Angle>() => Content::Angle,
                    _ => Content::Other,
                };
                self.schemas.insert(id, content);
                Some(())
            }
            op::CHANNEL => {
                let (id, schema) = (cursor.u16()?, cursor.u16()?);
                let topic = cursor.text()?;
                let content = match self.schemas.get(&schema) {
                    Some(Content::Frame) if topic != "/can" => Content::Other,
                    known => known.copied().unwrap_or(Content::Other),
                };
                let begin: String = topic.chars().take(60).collect();
                if let Some(run) = &mut self.run {
                    run.topics.insert(id, Topic::named(&begin));
                }
                self.channels.insert(id, (begin, content));
                Some(())
            }
            op::MESSAGE => {
                let channel = cursor.u16()?;
                let _sequence = cursor.u32()?;
                let time = cursor.u64()?;
                let _published = cursor.u64()?;
                if let Some(run) = &mut self.run {
                    if let Some(topic) = run.topics.get(&channel) {
                        run.told.extend(topic.read(time, cursor.0)?);
                    }
                    self.read.messages += 1;
                    self.read.last_ns = self.read.last_ns.max(time);
                    return Some(());
                }
                match self.channels.get(&channel).map(|c| c.1) {
                    Some(Content::Frame) => self.frames.push_back(messages::frame(time, cursor.0)?),
                    Some(Content::Entry) if !messages::agrees(time, cursor.0)? => {
                        let what = "pulses of a schedule message are not those of its times";
                        trouble = Some(what);
                    }
                    Some(Content::Angle) if !self.angle(channel, time, cursor.0)? => {
                        trouble = Some("a million angles of joints are held, more are left out");
                    }
                    Some(Content::Entry | Content::Angle) => {}
                    Some(Content::Other) | None => {}
                }
                self.read.messages += 1;
                self.read.last_ns = self.read.last_ns.max(time);
                Some(())
            }
            _ => Some(()), // indexes, and what later versions of the container bring
        };
        if parse().is_none() {
            let what = match kind {
                op::MESSAGE => "a damaged message is left out",
                _ => "a damaged record is left out",
            };
            self.damage(here, what);
        }
        if let Some(what) = trouble {
            self.damage(here, what);
        }
    }
}
