//! Parts of a dump's file, the numbers in them, and the packings of parts.

use std::io::{self, Read, Seek, SeekFrom};

use palpate_files::said;

use super::super::declared::{Wrong, damaged};
use super::super::leb128;

/// Most bytes of a part, packed or not.
pub(super) const MOST_PART: u64 = 64 << 20;

/// The file of a dump.
#[derive(Debug)]
pub(super) struct Source<R> {
    input: R,
    length: u64,
}

impl<R: Read + Seek> Source<R> {
    pub(super) fn new(mut input: R) -> Result<Self, Wrong> {
        let length = input.seek(SeekFrom::End(0)).map_err(unread)?;
        Ok(Self { input, length })
    }

    /// Bytes of the file.
    pub(super) const fn length(&self) -> u64 {
        self.length
    }

    /// The bytes of a part.
    pub(super) fn part(&mut self, at: u64, length: u64) -> Result<Vec<u8>, Wrong> {
        if length > MOST_PART {
            return Err(("parts of at most 64 MiB", format!("{length} bytes")));
        }
        let mut part = Vec::new();
        self.input.seek(SeekFrom::Start(at)).map_err(unread)?;
        let read = (&mut self.input).take(length).read_to_end(&mut part);
        match read.map_err(unread)? as u64 == length {
            true => Ok(part),
            false => Err(damaged("as many bytes as the dump states")),
        }
    }
}

fn unread(error: io::Error) -> Wrong {
    ("a file on a disk, no pipe", said(&error))
}

/// Bytes not yet read. Each method gives none where they end too early.
#[derive(Clone, Copy, Debug)]
pub(super) struct Bytes<'a>(pub(super) &'a [u8]);

impl<'a> Bytes<'a> {
    pub(super) fn take(&mut self, length: u64) -> Option<&'a [u8]> {
        let (taken, rest) = self.0.split_at_checked(usize::try_from(length).ok()?)?;
        self.0 = rest;
        Some(taken)
    }

    pub(super) fn byte(&mut self) -> Option<u8> {
        self.take(1)?.first().copied()
    }

    /// A number of eight bytes, the highest first.
    pub(super) fn wide(&mut self) -> Option<u64> {
        self.take(8)?.try_into().ok().map(u64::from_be_bytes)
    }

    /// A number in LEB128.
    pub(super) fn number(&mut self) -> Option<u64> {
        leb128::unsigned(|| self.byte().ok_or(())).ok().flatten()
    }

    /// A number with a sign, in LEB128.
    pub(super) fn signed(&mut self) -> Option<i64> {
        leb128::signed(|| self.byte().ok_or(())).ok().flatten()
    }

    /// A text up to a NUL, without it.
    pub(super) fn text(&mut self) -> Option<String> {
        let length = self.0.iter().position(|byte| *byte == 0)?;
        let text = self.take(length as u64)?;
        self.byte()?;
        Some(String::from_utf8_lossy(text).into_owned())
    }
}

/// A way to pack a part.
#[derive(Clone, Copy, Debug)]
pub(super) enum Packing {
    Gzip,
    Zlib,
    Lz4,
    FastLz,
}

impl Packing {
    /// The `length` bytes that were packed; none where they are other ones.
    pub(super) fn unpack(self, packed: &[u8], length: u64) -> Option<Vec<u8>> {
        use miniz_oxide::inflate::{
            decompress_to_vec_with_limit, decompress_to_vec_zlib_with_limit,
        };
        let most = usize::try_from(length.min(MOST_PART)).ok()?;
        let plain = match self {
            Self::Gzip => {
                let stream = packed.strip_prefix(&[0x1f, 0x8b, 8, 0])?.get(6..)?;
                decompress_to_vec_with_limit(stream, most).ok()?
            }
            Self::Zlib => decompress_to_vec_zlib_with_limit(packed, most).ok()?,
            Self::Lz4 => lz4_flex::block::decompress(packed, most).ok()?,
            Self::FastLz => fast_lz(packed, most)?,
        };
        (plain.len() as u64 == length).then_some(plain)
    }
}

/// The bytes of a part that is packed by zlib, unless packing would have made it longer.
pub(super) fn perhaps_zlib(part: Vec<u8>, length: u64) -> Option<Vec<u8>> {
    match part.len() as u64 == length {
        true => Some(part),
        false => Packing::Zlib.unpack(&part, length),
    }
}

/// At most `most` bytes that `FastLZ` packed: runs of literals, and matches of a length and a distance. Level 2 has longer ones.
fn fast_lz(packed: &[u8], most: usize) -> Option<Vec<u8>> {
    let mut input = Bytes(packed);
    let is_second = match packed.first()? >> 5 {
        0 => false,
        1 => true,
        _ => return None,
    };
    let mut plain = Vec::new();
    let mut operation = input.byte()? & 0x1f;
    loop {
        if operation < 0x20 {
            plain.extend(input.take(u64::from(operation) + 1)?);
        } else {
            let mut length = usize::from(operation >> 5) + 2;
            let mut distance = usize::from(operation & 0x1f) << 8;
            while length >= 9 {
                let more = input.byte()?;
                length += usize::from(more);
                if more < 0xff || !is_second || length > most {
                    break;
                }
            }
            let low = input.byte()?;
            distance += usize::from(low);
            if is_second && low == 0xff && operation & 0x1f == 0x1f {
                let far = input.take(2)?;
                distance = 0x1fff + usize::from(far[0]) * 0x100 + usize::from(far[1]);
            }
            let start = plain.len().checked_sub(distance + 1)?;
            if plain.len() + length > most {
                return None;
            }
            // a match may reach into the bytes that it makes
            (start..start + length).for_each(|at| plain.push(plain[at]));
        }
        match input.byte() {
            Some(next) => operation = next,
            None => return Some(plain),
        }
    }
}
