//! What a recording holds of the sensor buses, as far as it is whole: a file that was cut short or is damaged
//! gives what can be had, with the offset where that ends; one of another version is refused by name.

use std::collections::BTreeMap;
use std::fmt;
use std::io::{self, Read as _};

use palpate_core::bus::Received;
use palpate_core::codec::can::CanFrame;
use palpate_core::units::Instant;

use super::container::{MAGIC, op};
use super::proto::{Fields, Value};
use super::{PROFILE, VERSION, schema};

/// What could be read.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Read {
    /// Versions, digests and names, as the file's metadata has them.
    pub metadata: BTreeMap<String, String>,
    /// Frames on the sensor buses, in the order of the file.
    pub frames: Vec<Received>,
    /// Messages of all topics.
    pub messages: u64,
    /// Names and contents of the attached files.
    pub attachments: Vec<(String, Vec<u8>)>,
    /// What is wrong with the file; a chunk whose checksum fails is left out and the rest is read.
    pub damages: Vec<Tear>,
    /// Time of the last whole message, nanoseconds.
    pub last_ns: u64,
}

/// A place where the file is not what it should be.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Tear {
    /// Byte of the record that is damaged, or where the file ends.
    pub offset: u64,
    /// What is wrong there.
    pub what: &'static str,
}

impl fmt::Display for Tear {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "byte {}: {}", self.offset, self.what)
    }
}

/// Why nothing can be had of a file: what was expected and what was found.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Unreadable {
    /// What was expected.
    pub expected: String,
    /// What was found, with its place.
    pub found: String,
}

fn unreadable(expected: &str, found: impl Into<String>) -> Unreadable {
    Unreadable {
        expected: expected.into(),
        found: found.into(),
    }
}

/// Little-endian fields of a record.
struct Cursor<'a>(&'a [u8]);

impl<'a> Cursor<'a> {
    fn take(&mut self, n: usize) -> Option<&'a [u8]> {
        let (taken, rest) = self.0.split_at_checked(n)?;
        self.0 = rest;
        Some(taken)
    }
    fn u16(&mut self) -> Option<u16> {
        Some(u16::from_le_bytes(self.take(2)?.try_into().ok()?))
    }
    fn u32(&mut self) -> Option<u32> {
        Some(u32::from_le_bytes(self.take(4)?.try_into().ok()?))
    }
    fn u64(&mut self) -> Option<u64> {
        Some(u64::from_le_bytes(self.take(8)?.try_into().ok()?))
    }
    fn sized(&mut self) -> Option<&'a [u8]> {
        let n = usize::try_from(self.u32()?).ok()?;
        self.take(n)
    }
    fn text(&mut self) -> Option<String> {
        String::from_utf8(self.sized()?.to_vec()).ok()
    }
    /// The next record: kind and body.
    fn record(&mut self) -> Option<(u8, &'a [u8])> {
        let before = self.0;
        let whole = || {
            let kind = self.take(1)?[0];
            let length = usize::try_from(self.u64()?).ok()?;
            Some((kind, self.take(length)?))
        };
        let record = { whole }();
        if record.is_none() {
            self.0 = before;
        }
        record
    }
}

/// Longest record, bytes: a chunk of ours has a few MiB, and one of another program seldom more.
const MOST_RECORD: u64 = 64 << 20;

/// Reads a recording of ours from memory.
///
/// # Errors
/// [`Unreadable`] for what is no MCAP file, is compressed, is of another version or holds no sensor bus.
pub fn read(bytes: &[u8]) -> Result<Read, Unreadable> {
    let mut frames = Vec::new();
    let mut read = read_from(bytes, &mut |frame| {
        frames.push(frame);
        Ok(())
    })?;
    read.frames = frames;
    Ok(read)
}

/// Reads a recording of ours record by record; frames go to `take` in the order of the file.
///
/// # Errors
/// As [`read`], a record of more than 64 MiB, and what `take` refuses.
pub fn read_from(
    input: impl io::Read,
    take: &mut dyn FnMut(Received) -> Result<(), Unreadable>,
) -> Result<Read, Unreadable> {
    let mut input = Counted { input, offset: 0 };
    let mut record = Vec::new();
    if !input.fill(&mut record, MAGIC.len() as u64)? || record != MAGIC {
        let found = format!("byte 0: {}", record.escape_ascii());
        return Err(unreadable("an MCAP file", found));
    }
    let mut reader = Reader {
        read: Read::default(),
        schemas: BTreeMap::new(),
        channels: BTreeMap::new(),
        versioned: false,
        refused: None,
        take,
    };
    loop {
        let here = input.offset;
        let head = input.fill(&mut record, 9)?;
        let (kind, length) = match record.split_first() {
            Some((kind, length)) if head => {
                let length = length.try_into().map_or(u64::MAX, u64::from_le_bytes);
                (*kind, length)
            }
            _ => {
                reader.damage(input.offset, "the file is cut short here");
                break;
            }
        };
        if matches!(kind, op::DATA_END | op::FOOTER) {
            // The summary says nothing that was not said before; but it tells whether the end is there.
            if !input.ends_with(&MAGIC)? {
                reader.damage(input.offset, "the end of the summary is missing");
            }
            break;
        }
        if kind == 0 {
            reader.damage(here, "no record begins here");
            break;
        }
        let whole = input.fill(&mut record, length.min(MOST_RECORD))?;
        if whole && length > MOST_RECORD {
            let expected = format!("records of at most {MOST_RECORD} bytes");
            return Err(unreadable(&expected, format!("byte {here}: {length}")));
        }
        if !whole {
            if kind == op::CHUNK {
                reader.torn_chunk(&record, here);
            }
            reader.damage(input.offset, "the file is cut short here");
            break;
        }
        reader.top(kind, &record, here)?;
        reader.refused.take().map_or(Ok(()), Err)?;
    }
    reader.refused.take().map_or(Ok(()), Err)?;
    reader.finish()
}

/// A stream that knows how far it was read.
struct Counted<R> {
    input: R,
    offset: u64,
}

impl<R: io::Read> Counted<R> {
    /// So many bytes in place of those in `record`; false where the stream ends before.
    fn fill(&mut self, record: &mut Vec<u8>, length: u64) -> Result<bool, Unreadable> {
        record.clear();
        let read = self.input.by_ref().take(length).read_to_end(record);
        let read = read.map_err(|e| unreadable("a readable file", e.to_string()))? as u64;
        self.offset += read;
        Ok(read == length)
    }

    /// Reads what is left; whether it ends so.
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

struct Reader<'a> {
    read: Read,
    /// Schemas by number.
    schemas: BTreeMap<u16, String>,
    /// Channels by number: topic, and whether its messages are frames.
    channels: BTreeMap<u16, (String, bool)>,
    versioned: bool,
    /// Where frames go, and what that refused.
    take: &'a mut dyn FnMut(Received) -> Result<(), Unreadable>,
    refused: Option<Unreadable>,
}

impl Reader<'_> {
    fn damage(&mut self, offset: u64, what: &'static str) {
        self.read.damages.push(Tear { offset, what });
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
                Some(file) => self.read.attachments.push(file),
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

    /// What is there of a chunk that the file's end cuts short: its checksum cannot be asked, its records are
    /// whole or not there.
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
        let mut parse = || match kind {
            op::SCHEMA => {
                let id = cursor.u16()?;
                self.schemas.insert(id, cursor.text()?);
                Some(())
            }
            op::CHANNEL => {
                let (id, schema) = (cursor.u16()?, cursor.u16()?);
                let topic = cursor.text()?;
                let name = self.schemas.get(&schema).map_or("", |s| s);
                let is_can = topic == "/can" && name == schema::CAN.full_name();
                self.channels.insert(id, (topic, is_can));
                Some(())
            }
            op::MESSAGE => {
                let channel = cursor.u16()?;
                let _sequence = cursor.u32()?;
                let time = cursor.u64()?;
                let _published = cursor.u64()?;
                if self.channels.get(&channel).is_some_and(|c| c.1) {
                    let frame = frame(time, cursor.0)?;
                    if self.refused.is_none() {
                        self.refused = (self.take)(frame).err();
                    }
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
    }
}

fn metadata(record: &[u8]) -> Option<(String, BTreeMap<String, String>)> {
    let mut cursor = Cursor(record);
    let name = cursor.text()?;
    let mut entries = Cursor(cursor.sized()?);
    let mut map = BTreeMap::new();
    while !entries.0.is_empty() {
        map.insert(entries.text()?, entries.text()?);
    }
    Some((name, map))
}

fn attachment(record: &[u8]) -> Option<(String, Vec<u8>)> {
    let mut cursor = Cursor(record);
    let (_logged, _created) = (cursor.u64()?, cursor.u64()?);
    let (name, _media_type) = (cursor.text()?, cursor.text()?);
    let size = usize::try_from(cursor.u64()?).ok()?;
    let data = cursor.take(size)?.to_vec();
    let crc = cursor.u32()?;
    let covered = record.get(..record.len() - 4)?;
    (crc == 0 || crc == crc32fast::hash(covered)).then_some((name, data))
}

struct ChunkHead {
    crc: u32,
    compression: String,
    size: u64,
}

/// The head of a chunk, and what follows it.
fn chunk_head(record: &[u8]) -> Option<(ChunkHead, &[u8])> {
    let mut cursor = Cursor(record);
    let (_first, _last, _size) = (cursor.u64()?, cursor.u64()?, cursor.u64()?);
    let crc = cursor.u32()?;
    let head = ChunkHead {
        crc,
        compression: cursor.text()?,
        size: cursor.u64()?,
    };
    Some((head, cursor.0))
}

/// A frame's message.
fn frame(t_ns: u64, message: &[u8]) -> Option<Received> {
    let (mut bus, mut id, mut data) = (0, 0, &[][..]);
    for field in Fields::new(message) {
        match field? {
            (1, Value::Number(n)) => bus = u8::try_from(n).ok()?,
            (2, Value::Number(n)) => id = u16::try_from(n).ok()?,
            (3, Value::Data(bytes)) => data = bytes,
            _ => {}
        }
    }
    Some(Received {
        at: Instant::from_micros(t_ns / 1000),
        bus,
        frame: CanFrame::new(id, data)?,
    })
}
