//! MCAP files with their chunks unpacked: others' recorders pack them by zstd or lz4.

use std::fs::File;
use std::io::{self, BufReader, Read};
use std::path::Path;

use super::error::FileError;
use super::reading::open;

const MAGIC: &[u8] = b"\x89MCAP0\r\n";
/// Kind and length in front of a record.
const HEAD: usize = 9;
/// Kind of a chunk, by the specification's number.
const CHUNK: u8 = 0x06;
/// Longest chunk that is unpacked, bytes, packed or not.
const MOST_CHUNK: u64 = 64 << 20;

/// An MCAP file whose packed chunks read as if they had been written without packing. A chunk of another packing, or one
/// that does not give the bytes that it promises, stays as it is.
#[derive(Debug)]
pub struct Unpacked<R> {
    input: BufReader<R>,
    /// Bytes to hand out next, and the place reached in them.
    ready: Vec<u8>,
    at: usize,
    /// Bytes of the record under way that are handed out as they are; the magic is none of them.
    passing: u64,
    is_begun: bool,
    has_unpacked: bool,
}

/// Opens an MCAP file, and unpacks its chunks as they are read.
///
/// # Errors
/// The errors of [`open`].
pub fn open_unpacked(path: &Path, expected: &str) -> Result<Unpacked<File>, FileError> {
    Ok(Unpacked::new(open(path, expected)?))
}

impl<R: Read> Unpacked<R> {
    /// Unpacks the chunks of a stream.
    pub fn new(input: R) -> Self {
        Self {
            input: BufReader::new(input),
            ready: Vec::new(),
            at: 0,
            passing: 0,
            is_begun: false,
            has_unpacked: false,
        }
    }

    /// Returns true once a chunk was unpacked. From there on the bytes are not those of the file.
    #[must_use]
    pub const fn has_unpacked(&self) -> bool {
        self.has_unpacked
    }

    /// Reads up to `most` bytes behind those that are ready; false where the stream ends before.
    fn fetch(&mut self, most: u64) -> io::Result<bool> {
        let read = (&mut self.input).take(most).read_to_end(&mut self.ready)?;
        Ok(read as u64 == most)
    }

    /// Makes the next bytes ready: the magic, the head of a record, or a whole chunk.
    fn advance(&mut self) -> io::Result<()> {
        self.ready.clear();
        self.at = 0;
        if !self.is_begun {
            self.is_begun = true;
            self.fetch(MAGIC.len() as u64)?;
            if self.ready != MAGIC {
                self.passing = u64::MAX; // another kind of file, which its reader refuses
            }
            return Ok(());
        }
        if !self.fetch(HEAD as u64)? {
            return Ok(());
        }
        let length = self.ready[1..].try_into().map_or(0, u64::from_le_bytes);
        if self.ready[0] != CHUNK || length > MOST_CHUNK {
            self.passing = length;
            return Ok(());
        }
        if self.fetch(length)?
            && let Some(chunk) = unpacked(&self.ready[HEAD..])
        {
            self.ready.truncate(1);
            self.ready.extend((chunk.len() as u64).to_le_bytes());
            self.ready.extend(chunk);
            self.has_unpacked = true;
        }
        Ok(())
    }
}

impl<R: Read> Read for Unpacked<R> {
    fn read(&mut self, out: &mut [u8]) -> io::Result<usize> {
        if self.at == self.ready.len() && self.passing == 0 {
            self.advance()?;
        }
        if self.at < self.ready.len() {
            let read = (&self.ready[self.at..]).read(out)?;
            self.at += read;
            return Ok(read);
        }
        let read = (&mut self.input).take(self.passing).read(out)?;
        self.passing -= read as u64;
        Ok(read)
    }
}

/// The body of a chunk without its packing; none where it is not packed or cannot be unpacked.
fn unpacked(body: &[u8]) -> Option<Vec<u8>> {
    let (times, rest) = body.split_at_checked(16)?;
    let (size, rest) = rest.split_first_chunk::<8>()?;
    let (crc, rest) = rest.split_first_chunk::<4>()?;
    let (length, rest) = rest.split_first_chunk::<4>()?;
    let length = usize::try_from(u32::from_le_bytes(*length)).ok()?;
    let (packing, rest) = rest.split_at_checked(length)?;
    let (length, rest) = rest.split_first_chunk::<8>()?;
    let packed = rest.get(..usize::try_from(u64::from_le_bytes(*length)).ok()?)?;
    let most = u64::from_le_bytes(*size);
    if most > MOST_CHUNK {
        return None;
    }
    let records = unpack(packing, packed, most)?;
    let stated = u32::from_le_bytes(*crc);
    let is_whole = stated == 0 || crc32fast::hash(&records) == stated;
    if records.len() as u64 != most || !is_whole {
        return None;
    }
    let none = 0_u32.to_le_bytes();
    Some([times, size, crc, &none, size, &records].concat())
}

/// At most `most` bytes of a packed frame, and one more where it has more than it promises; none of a packing that is not
/// read.
#[cfg(not(target_family = "wasm"))]
fn unpack(packing: &[u8], packed: &[u8], most: u64) -> Option<Vec<u8>> {
    let mut records = Vec::new();
    match packing {
        b"zstd" => {
            let frame = ruzstd::decoding::StreamingDecoder::new(packed).ok()?;
            frame.take(most + 1).read_to_end(&mut records).ok()?;
        }
        b"lz4" => {
            let frame = lz4_flex::frame::FrameDecoder::new(packed);
            frame.take(most + 1).read_to_end(&mut records).ok()?;
        }
        _ => return None,
    }
    Some(records)
}

/// No packing is read in a browser.
#[cfg(target_family = "wasm")]
fn unpack(_packing: &[u8], _packed: &[u8], _most: u64) -> Option<Vec<u8>> {
    None
}

#[cfg(test)]
#[path = "packed_tests.rs"]
mod tests;
