//! The container of a recording: [MCAP](https://mcap.dev/spec) with uncompressed chunks, their indexes and a
//! summary at the end, written front to back so that a pipe or a dying program leaves what is whole.

use std::collections::BTreeMap;
use std::io::{self, Write};

/// Bytes that every file starts and ends with.
pub(super) const MAGIC: [u8; 8] = *b"\x89MCAP0\r\n";

/// A chunk is closed when it has come to this size: what one wrong bit costs.
const CHUNK: usize = 1 << 18;

/// Kinds of record, by the specification's numbers.
pub(super) mod op {
    pub const HEADER: u8 = 0x01;
    pub const FOOTER: u8 = 0x02;
    pub const SCHEMA: u8 = 0x03;
    pub const CHANNEL: u8 = 0x04;
    pub const MESSAGE: u8 = 0x05;
    pub const CHUNK: u8 = 0x06;
    pub const MESSAGE_INDEX: u8 = 0x07;
    pub const CHUNK_INDEX: u8 = 0x08;
    pub const ATTACHMENT: u8 = 0x09;
    pub const ATTACHMENT_INDEX: u8 = 0x0a;
    pub const STATISTICS: u8 = 0x0b;
    pub const METADATA: u8 = 0x0c;
    pub const METADATA_INDEX: u8 = 0x0d;
    pub const SUMMARY_OFFSET: u8 = 0x0e;
    pub const DATA_END: u8 = 0x0f;
}

/// The body of a record.
#[derive(Clone, Debug, Default)]
struct Body(Vec<u8>);

impl Body {
    fn u16(mut self, v: u16) -> Self {
        self.0.extend(v.to_le_bytes());
        self
    }
    fn u32(mut self, v: u32) -> Self {
        self.0.extend(v.to_le_bytes());
        self
    }
    fn u64(mut self, v: u64) -> Self {
        self.0.extend(v.to_le_bytes());
        self
    }
    fn text(self, v: &str) -> Self {
        self.sized(v.as_bytes())
    }
    /// Bytes with their number in front.
    fn sized(mut self, v: &[u8]) -> Self {
        self.0.extend((v.len() as u32).to_le_bytes()); // nothing here comes near 4 GiB
        self.0.extend(v);
        self
    }
    fn map<'a>(self, entries: impl IntoIterator<Item = (&'a String, &'a String)>) -> Self {
        let mut inner = Self::default();
        for (key, value) in entries {
            inner = inner.text(key).text(value);
        }
        self.sized(&inner.0)
    }
    /// The record: kind, length, body.
    fn record(&self, kind: u8) -> Vec<u8> {
        let mut record = Vec::with_capacity(9 + self.0.len());
        record.push(kind);
        record.extend((self.0.len() as u64).to_le_bytes());
        record.extend(&self.0);
        record
    }
}

/// A file that goes with a recording.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Attachment {
    /// Name of the file.
    pub name: String,
    /// Media type, such as `application/toml`.
    pub media_type: &'static str,
    /// Content of the file.
    pub text: String,
}

/// A place for the topics of a recording and their messages: a file, or those who look on while the run goes on.
pub trait Store {
    /// Adds a protobuf schema, a `google.protobuf.FileDescriptorSet`. Returns its number, which counts from 1.
    ///
    /// # Errors
    /// The writer's error.
    fn schema(&mut self, name: &str, descriptor: &[u8]) -> io::Result<u16>;

    /// Adds a topic with this schema. Returns its number, which counts from 0.
    ///
    /// # Errors
    /// The writer's error.
    fn channel(&mut self, schema: u16, topic: &str) -> io::Result<u16>;

    /// Adds a message of a topic at a time in nanoseconds.
    ///
    /// # Errors
    /// The writer's error.
    fn message(&mut self, channel: u16, time: u64, data: &[u8]) -> io::Result<()>;
}

/// A file in the making.
#[derive(Debug)]
pub struct Container<W> {
    out: W,
    position: u64,
    /// Records of schemas and channels: they come again in the summary.
    schemas: Vec<Vec<u8>>,
    channels: Vec<Vec<u8>>,
    /// Messages so far, by channel.
    counts: Vec<u64>,
    chunk: Vec<u8>,
    /// Time and place in the chunk of its messages, by channel.
    index: Vec<Vec<(u64, u64)>>,
    /// First and last time of the chunk's messages, and of all.
    span: Option<(u64, u64)>,
    whole: Option<(u64, u64)>,
    chunk_indexes: Vec<Vec<u8>>,
    attachments: Vec<Vec<u8>>,
    metadata: Vec<Vec<u8>>,
}

fn widen(span: &mut Option<(u64, u64)>, time: u64) {
    let (first, last) = span.unwrap_or((time, time));
    *span = Some((first.min(time), last.max(time)));
}

impl<W: Write> Store for Container<W> {
    fn schema(&mut self, name: &str, descriptor: &[u8]) -> io::Result<u16> {
        let id = self.schemas.len() as u16 + 1; // a dozen
        let body = Body::default()
            .u16(id)
            .text(name)
            .text("protobuf")
            .sized(descriptor);
        let record = body.record(op::SCHEMA);
        self.put(&record)?;
        self.schemas.push(record);
        Ok(id)
    }

    fn channel(&mut self, schema: u16, topic: &str) -> io::Result<u16> {
        let id = self.channels.len() as u16; // a few for each of 256 wires at most
        let body = Body::default()
            .u16(id)
            .u16(schema)
            .text(topic)
            .text("protobuf")
            .sized(&[]);
        let record = body.record(op::CHANNEL);
        self.put(&record)?;
        self.channels.push(record);
        self.counts.push(0);
        self.index.push(Vec::new());
        Ok(id)
    }

    fn message(&mut self, channel: u16, time: u64, data: &[u8]) -> io::Result<()> {
        let slot = usize::from(channel);
        let sequence = self.counts[slot] as u32; // wraps where it has to
        self.counts[slot] += 1;
        self.index[slot].push((time, self.chunk.len() as u64));
        widen(&mut self.span, time);
        let mut head = [0; 31];
        head[0] = op::MESSAGE;
        head[1..9].copy_from_slice(&(22 + data.len() as u64).to_le_bytes());
        head[9..11].copy_from_slice(&channel.to_le_bytes());
        head[11..15].copy_from_slice(&sequence.to_le_bytes());
        head[15..23].copy_from_slice(&time.to_le_bytes());
        head[23..31].copy_from_slice(&time.to_le_bytes());
        self.chunk.extend_from_slice(&head);
        self.chunk.extend_from_slice(data);
        if self.chunk.len() >= CHUNK {
            self.close_chunk()?;
        }
        Ok(())
    }
}

impl<W: Write> Container<W> {
    pub(super) fn begin(out: W, profile: &str, library: &str) -> io::Result<Self> {
        let mut container = Self {
            out,
            position: 0,
            schemas: Vec::new(),
            channels: Vec::new(),
            counts: Vec::new(),
            chunk: Vec::with_capacity(CHUNK + CHUNK / 8),
            index: Vec::new(),
            span: None,
            whole: None,
            chunk_indexes: Vec::new(),
            attachments: Vec::new(),
            metadata: Vec::new(),
        };
        container.put(&MAGIC)?;
        let header = Body::default().text(profile).text(library);
        container.put(&header.record(op::HEADER))?;
        Ok(container)
    }

    pub(super) const fn get_mut(&mut self) -> &mut W {
        &mut self.out
    }

    fn put(&mut self, bytes: &[u8]) -> io::Result<()> {
        self.out.write_all(bytes)?;
        self.position += bytes.len() as u64;
        Ok(())
    }

    pub(super) fn metadata(
        &mut self,
        name: &str,
        values: &BTreeMap<String, String>,
    ) -> io::Result<()> {
        let record = Body::default().text(name).map(values).record(op::METADATA);
        let index = Body::default()
            .u64(self.position)
            .u64(record.len() as u64)
            .text(name);
        self.metadata.push(index.record(op::METADATA_INDEX));
        self.put(&record)
    }

    pub(super) fn attach(&mut self, file: &Attachment) -> io::Result<()> {
        let size = file.text.len() as u64;
        let mut body = Body::default()
            .u64(0)
            .u64(0)
            .text(&file.name)
            .text(file.media_type)
            .u64(size);
        body.0.extend(file.text.as_bytes());
        let crc = crc32fast::hash(&body.0);
        let record = body.u32(crc).record(op::ATTACHMENT);
        let index = Body::default()
            .u64(self.position)
            .u64(record.len() as u64)
            .u64(0)
            .u64(0)
            .u64(size)
            .text(&file.name)
            .text(file.media_type);
        self.attachments.push(index.record(op::ATTACHMENT_INDEX));
        self.put(&record)
    }

    /// Hands over what is there: a reader finds it even if nothing more comes.
    pub(super) fn flush(&mut self) -> io::Result<()> {
        self.close_chunk()?;
        self.out.flush()
    }

    fn close_chunk(&mut self) -> io::Result<()> {
        let Some((first, last)) = self.span.take() else {
            return Ok(());
        };
        widen(&mut self.whole, first);
        widen(&mut self.whole, last);
        let (start, size) = (self.position, self.chunk.len() as u64);
        let head = Body::default()
            .u64(first)
            .u64(last)
            .u64(size)
            .u32(crc32fast::hash(&self.chunk))
            .text("")
            .u64(size);
        let mut record = vec![op::CHUNK];
        record.extend((head.0.len() as u64 + size).to_le_bytes());
        record.extend(&head.0);
        self.put(&record)?;
        let chunk = std::mem::take(&mut self.chunk);
        self.put(&chunk)?;
        self.chunk = chunk;
        self.chunk.clear();
        let indexes = self.position;
        let mut offsets = Body::default();
        for channel in 0..self.index.len() {
            if self.index[channel].is_empty() {
                continue;
            }
            offsets = offsets.u16(channel as u16).u64(self.position);
            let mut entries = Vec::with_capacity(16 * self.index[channel].len());
            for (time, place) in self.index[channel].drain(..) {
                entries.extend(time.to_le_bytes());
                entries.extend(place.to_le_bytes());
            }
            let body = Body::default().u16(channel as u16).sized(&entries);
            self.put(&body.record(op::MESSAGE_INDEX))?;
        }
        let index = Body::default()
            .u64(first)
            .u64(last)
            .u64(start)
            .u64(indexes - start)
            .sized(&offsets.0)
            .u64(self.position - indexes)
            .text("")
            .u64(size)
            .u64(size);
        self.chunk_indexes.push(index.record(op::CHUNK_INDEX));
        Ok(())
    }

    /// Closes the file with its summary.
    pub(super) fn finish(mut self) -> io::Result<W> {
        self.close_chunk()?;
        self.put(&Body::default().u32(0).record(op::DATA_END))?;
        let (first, last) = self.whole.unwrap_or((0, 0));
        let mut counts = Body::default();
        for (channel, count) in self.counts.iter().enumerate().filter(|c| *c.1 > 0) {
            counts = counts.u16(channel as u16).u64(*count);
        }
        let statistics = Body::default()
            .u64(self.counts.iter().sum())
            .u16(self.schemas.len() as u16)
            .u32(self.channels.len() as u32)
            .u32(self.attachments.len() as u32)
            .u32(self.metadata.len() as u32)
            .u32(self.chunk_indexes.len() as u32)
            .u64(first)
            .u64(last)
            .sized(&counts.0)
            .record(op::STATISTICS);
        let start = self.position;
        let (mut summary, mut offsets) = (Vec::new(), Vec::new());
        for (kind, group) in [
            (op::SCHEMA, &self.schemas),
            (op::CHANNEL, &self.channels),
            (op::STATISTICS, &vec![statistics]),
            (op::CHUNK_INDEX, &self.chunk_indexes),
            (op::ATTACHMENT_INDEX, &self.attachments),
            (op::METADATA_INDEX, &self.metadata),
        ] {
            let begun = summary.len() as u64;
            summary.extend(group.iter().flatten());
            let length = summary.len() as u64 - begun;
            if length > 0 {
                let mut body = Body(vec![kind]);
                body = body.u64(start + begun).u64(length);
                offsets.extend(body.record(op::SUMMARY_OFFSET));
            }
        }
        let offset_start = start + summary.len() as u64;
        summary.extend(offsets);
        let footer = Body::default().u64(start).u64(offset_start);
        // The checksum covers the summary and the footer up to itself.
        let mut record = footer.u32(0).record(op::FOOTER);
        let end = record.len() - 4;
        let mut crc = crc32fast::Hasher::new();
        crc.update(&summary);
        crc.update(&record[..end]);
        record[end..].copy_from_slice(&crc.finalize().to_le_bytes());
        self.put(&summary)?;
        self.put(&record)?;
        self.put(&MAGIC)?;
        self.out.flush()?;
        Ok(self.out)
    }
}
