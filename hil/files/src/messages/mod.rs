//! Messages of an MCAP file as the text of a table: a row for each message of the topic that holds most numbers.
//!
//! A column is named by its fields and places in lists, `data.0`; the first column is the time at which a message was
//! logged. The reader takes bags of ROS 2 (CDR) and messages in JSON.

mod cdr;

use std::collections::BTreeMap;
use std::fs::File;
use std::io::{self, Read};
use std::path::Path;

use super::error::{FileError, said};
use super::made::Lines;
use super::objects::flatten;
use super::packed::{Unpacked, open_unpacked};
use super::shape::Shape;
use cdr::Definition;

const MAGIC: &[u8] = b"\x89MCAP0\r\n";
/// Longest record, bytes.
const MOST_RECORD: u64 = 64 << 20;
/// Messages that are looked at to choose a topic.
const LOOKED_AT: usize = 1000;
/// The topic of this project's recordings: frames of a bus.
const CAN: &str = "/can";

/// Kinds of record, by the specification's numbers.
mod op {
    pub const SCHEMA: u8 = 0x03;
    pub const CHANNEL: u8 = 0x04;
    pub const MESSAGE: u8 = 0x05;
    pub const CHUNK: u8 = 0x06;
    pub const DATA_END: u8 = 0x0f;
}

/// A message as its numbers, each with its name.
type Leaves = Vec<(String, String)>;

/// Reads a file message by message.
pub(super) struct Messages {
    records: Records,
    topic: u16,
    name: String,
    note: String,
    /// Names of the columns, once they are known.
    names: Vec<String>,
    /// The text that messages in JSON have around their numbers, if they have the same.
    shape: Option<Shape>,
}

/// Returns true if a file holds frames of a bus, like those that this program writes, or ends before it states what
/// it holds.
#[must_use]
pub fn holds_frames(path: &Path) -> bool {
    let Ok(mut records) = Records::open(path) else {
        return true; // reading it will say why
    };
    for _ in 0..LOOKED_AT {
        if records
            .channels
            .values()
            .any(|channel| channel.topic == CAN)
        {
            return true;
        }
        if !matches!(records.advance(), Ok(Some(_))) {
            break;
        }
    }
    let mut topics = records
        .channels
        .values()
        .map(|channel| channel.topic.as_str());
    records.channels.is_empty() || topics.any(|topic| topic == CAN)
}

impl Messages {
    /// Opens a file, and looks for a topic: the one that is named, else the one with the most numbers.
    ///
    /// # Errors
    /// A file without messages of that topic, or without a message that the reader takes. It names the topics.
    pub(super) fn open(path: &Path, named: Option<&str>) -> Result<Self, FileError> {
        let mut records = Records::open(path)?;
        let mut most: BTreeMap<u16, usize> = BTreeMap::new();
        let mut messages = 0;
        // A topic that is named may have its first message late.
        let mut is_missed = named.is_some();
        while messages < LOOKED_AT || is_missed {
            let Some(message) = records.advance()? else {
                break;
            };
            messages += 1;
            let count = records.leaves(&message)?.map_or(0, |leaves| leaves.len());
            let known = most.entry(message.channel).or_default();
            *known = count.max(*known);
            is_missed &= count == 0 || !records.is_of(message.channel, named);
        }
        let fits = |channel: &u16, count: usize| {
            count > 0 && (named.is_none() || records.is_of(*channel, named))
        };
        let fitting = most
            .iter()
            .filter(|(channel, count)| fits(channel, **count));
        let best = fitting.max_by_key(|(channel, count)| (**count, std::cmp::Reverse(**channel)));
        let Some((&topic, _)) = best else {
            let expected = match named {
                Some(name) => format!(
                    "messages of numbers under the topic `{name}` (--topic), in CDR with a schema (ROS 2) or in JSON"
                ),
                None => "messages of numbers, in CDR with a schema (ROS 2) or in JSON".to_owned(),
            };
            let found = match records.told(&most).as_str() {
                "" => "no messages".to_owned(),
                topics => topics.to_owned(),
            };
            return Err(FileError::whole(&records.label, expected, found));
        };
        let name = records
            .channels
            .get(&topic)
            .map_or_else(String::new, |c| c.topic.clone());
        let mut note = format!("{}: rows are the messages of topic `{name}`", records.label);
        most.retain(|channel, count| *count > 0 && !records.is_of(*channel, Some(&name)));
        if named.is_none() && !most.is_empty() {
            note += &format!(
                ", which has the most numbers (--topic takes another: {})",
                records.told(&most)
            );
        }
        Ok(Self {
            records: Records::open(path)?,
            topic,
            name,
            note,
            names: Vec::new(),
            shape: None,
        })
    }

    /// Remark on the choice of the topic.
    pub(super) fn note(&self) -> String {
        self.note.clone()
    }
}

impl Lines for Messages {
    fn add(&mut self, text: &mut Vec<u8>) -> Result<bool, FileError> {
        let Some(message) = self.records.advance()? else {
            return Ok(false);
        };
        if message.channel != self.topic {
            return Ok(true);
        }
        if let Some(shape) = &mut self.shape {
            let before = text.len();
            text.extend(message.log_ns.to_string().bytes());
            if shape.add(&message.data, text) {
                text.push(b'\n');
                return Ok(true);
            }
            text.truncate(before);
        }
        let Some(leaves) = self.records.leaves(&message)? else {
            return Ok(true);
        };
        if self.names.is_empty() {
            self.names = leaves.iter().map(|(name, _)| name.clone()).collect();
            self.shape = Shape::find(&message.data, &self.names);
            text.extend(format!("time_ns,{}\n", self.names.join(",")).bytes());
        }
        let is_same = leaves.len() == self.names.len()
            && leaves
                .iter()
                .zip(&self.names)
                .all(|((name, _), known)| name == known);
        if !is_same {
            let found = format!("{} numbers", leaves.len());
            let expected = format!(
                "messages of topic `{}` with the {} numbers of the first",
                self.name,
                self.names.len()
            );
            return Err(FileError::whole(&self.records.label, expected, found));
        }
        text.extend(message.log_ns.to_string().bytes());
        for (_, value) in leaves {
            text.push(b',');
            text.extend(value.bytes());
        }
        text.push(b'\n');
        Ok(true)
    }
}

/// Topic, encoding and schema of messages.
struct Channel {
    topic: String,
    encoding: String,
    /// Number of the schema.
    schema: u16,
}

struct Message {
    channel: u16,
    log_ns: u64,
    data: Vec<u8>,
}

/// The records of a file, with those in chunks.
struct Records {
    label: String,
    input: Unpacked<File>,
    definitions: BTreeMap<u16, Definition>,
    channels: BTreeMap<u16, Channel>,
    /// The chunk under way, and the place reached in it.
    chunk: Vec<u8>,
    at: usize,
}

impl Records {
    fn open(path: &Path) -> Result<Self, FileError> {
        let label = path.display().to_string();
        let mut input = open_unpacked(path, "a recording (MCAP)")?;
        let mut magic = [0; MAGIC.len()];
        let read = input.read_exact(&mut magic);
        if read.is_err() || magic != MAGIC {
            return Err(FileError::whole(label, "an MCAP file", "another beginning"));
        }
        Ok(Self {
            label,
            input,
            definitions: BTreeMap::new(),
            channels: BTreeMap::new(),
            chunk: Vec::new(),
            at: 0,
        })
    }

    /// The next message; none at the end. A message that the file was cut in is left out.
    fn advance(&mut self) -> Result<Option<Message>, FileError> {
        loop {
            let record = match self.of_chunk() {
                Some(record) => Some(record),
                None => self.of_file()?,
            };
            let Some((kind, body)) = record else {
                return Ok(None);
            };
            match kind {
                op::DATA_END => return Ok(None),
                op::CHUNK => self.open_chunk(&body)?,
                op::SCHEMA => drop(self.schema(&body)),
                op::CHANNEL => drop(self.channel(&body)),
                op::MESSAGE => {
                    if let Some(message) = message(body) {
                        return Ok(Some(message));
                    }
                }
                _ => {}
            }
        }
    }

    fn of_file(&mut self) -> Result<Option<(u8, Vec<u8>)>, FileError> {
        let mut head = [0; 9];
        if self.input.read_exact(&mut head).is_err() {
            return Ok(None);
        }
        let (kind, length) = head.split_at(1);
        let length = length.try_into().map_or(u64::MAX, u64::from_le_bytes);
        if length > MOST_RECORD {
            let expected = format!("records of at most {MOST_RECORD} bytes");
            return Err(FileError::whole(&self.label, expected, format!("{length}")));
        }
        let mut body = vec![0; length as usize];
        match self.input.read_exact(&mut body) {
            Ok(()) => Ok(Some((kind[0], body))),
            Err(error) if error.kind() == io::ErrorKind::UnexpectedEof => Ok(None),
            Err(error) => {
                let found = said(&error);
                Err(FileError::whole(&self.label, "a readable file", found))
            }
        }
    }

    fn of_chunk(&mut self) -> Option<(u8, Vec<u8>)> {
        let mut rest = Bytes(self.chunk.get(self.at..)?);
        let kind = rest.number(1)? as u8;
        let length = usize::try_from(rest.number(8)?).ok()?;
        let body = rest.take(length)?.to_vec();
        self.at += 9 + length;
        Some((kind, body))
    }

    fn open_chunk(&mut self, body: &[u8]) -> Result<(), FileError> {
        let mut bytes = Bytes(body);
        let mut parts = || -> Option<(String, Vec<u8>)> {
            bytes.take(28)?;
            let packing = bytes.text()?;
            let length = usize::try_from(bytes.number(8)?).ok()?;
            Some((packing, bytes.take(length)?.to_vec()))
        };
        let Some((packing, records)) = parts() else {
            return Ok(());
        };
        if !packing.is_empty() {
            let expected = "whole chunks, packed by zstd, lz4 or not at all (mcap recover FILE.mcap -o OUT.mcap)";
            return Err(FileError::whole(&self.label, expected, packing));
        }
        (self.chunk, self.at) = (records, 0);
        Ok(())
    }

    fn schema(&mut self, body: &[u8]) -> Option<()> {
        let mut bytes = Bytes(body);
        let id = bytes.number(2)? as u16;
        let (name, encoding) = (bytes.text()?, bytes.text()?);
        if encoding == "ros2msg" {
            let text = bytes.text()?;
            self.definitions.insert(id, Definition::parse(&name, &text));
        }
        Some(())
    }

    fn channel(&mut self, body: &[u8]) -> Option<()> {
        let mut bytes = Bytes(body);
        let (id, schema) = (bytes.number(2)? as u16, bytes.number(2)? as u16);
        let channel = Channel {
            topic: bytes.text()?,
            encoding: bytes.text()?,
            schema,
        };
        self.channels.insert(id, channel);
        Some(())
    }

    /// Tells whether a channel is of the topic that is named.
    fn is_of(&self, channel: u16, named: Option<&str>) -> bool {
        self.channels
            .get(&channel)
            .is_some_and(|channel| named == Some(channel.topic.as_str()))
    }

    /// The topics of messages, each with its encoding and with how many numbers its messages have.
    fn told(&self, numbers: &BTreeMap<u16, usize>) -> String {
        let told = |(number, channel): (&u16, &Channel)| {
            let count = numbers.get(number).filter(|count| **count > 0);
            let count = count.map_or_else(String::new, |count| format!(", {count} numbers"));
            format!("{} ({}{count})", channel.topic, channel.encoding)
        };
        let topics = self
            .channels
            .iter()
            .filter(|(number, _)| numbers.contains_key(number));
        topics.map(told).collect::<Vec<_>>().join(", ")
    }

    /// The numbers of a message; none for another encoding.
    fn leaves(&self, message: &Message) -> Result<Option<Leaves>, FileError> {
        let Some(channel) = self.channels.get(&message.channel) else {
            return Ok(None);
        };
        let broken = || {
            let expected = format!("whole messages of topic `{}`", channel.topic);
            FileError::whole(
                &self.label,
                expected,
                format!("one of {} bytes", message.data.len()),
            )
        };
        let mut leaves = Vec::new();
        match channel.encoding.as_str() {
            "json" => {
                let value = serde_json::from_slice(&message.data).map_err(|_| broken())?;
                flatten("", &value, &mut leaves);
            }
            "cdr" => {
                let Some(definition) = self.definitions.get(&channel.schema) else {
                    return Ok(None);
                };
                definition
                    .read(&message.data, &mut leaves)
                    .ok_or_else(broken)?;
            }
            _ => return Ok(None),
        }
        Ok(Some(leaves))
    }
}

fn message(mut body: Vec<u8>) -> Option<Message> {
    let mut bytes = Bytes(&body);
    let channel = bytes.number(2)? as u16;
    bytes.take(4)?;
    let log_ns = bytes.number(8)?;
    bytes.take(8)?;
    let head = body.len() - bytes.0.len();
    body.drain(..head);
    Some(Message {
        channel,
        log_ns,
        data: body,
    })
}

/// Bytes of a record that are still to be read.
struct Bytes<'b>(&'b [u8]);

impl<'b> Bytes<'b> {
    fn take(&mut self, length: usize) -> Option<&'b [u8]> {
        let (taken, rest) = self.0.split_at_checked(length)?;
        self.0 = rest;
        Some(taken)
    }

    /// A little-endian number of up to eight bytes.
    fn number(&mut self, width: usize) -> Option<u64> {
        let bytes = self.take(width)?.iter().rev();
        Some(bytes.fold(0, |number, byte| number << 8 | u64::from(*byte)))
    }

    /// A text with its length in front.
    fn text(&mut self) -> Option<String> {
        let length = usize::try_from(self.number(4)?).ok()?;
        let bytes = self.take(length)?;
        Some(String::from_utf8_lossy(bytes).into_owned())
    }
}

#[cfg(test)]
mod tests;
