//! Bytes and numbers of a dump, read one after another.

use std::io::{BufRead, BufReader, ErrorKind, Read};

use palpate_files::said;

use super::super::declared::{Wrong, damaged};
use super::super::leb128;

/// The file of a dump.
#[derive(Debug)]
pub(super) struct Input<R> {
    input: BufReader<R>,
    /// Words begin with their highest byte.
    pub(super) is_big_endian: bool,
    /// The part that is read, as errors name it.
    pub(super) part: &'static str,
}

impl<R: Read> Input<R> {
    pub(super) fn new(input: R) -> Self {
        Self {
            input: BufReader::new(input),
            is_big_endian: false,
            part: "a header of GHW",
        }
    }

    /// The refusal of a damaged part.
    pub(super) fn wrong(&self) -> Wrong {
        damaged(self.part)
    }

    /// The next bytes.
    pub(super) fn take<const N: usize>(&mut self) -> Result<[u8; N], Wrong> {
        let mut bytes = [0; N];
        match self.input.read_exact(&mut bytes) {
            Ok(()) => Ok(bytes),
            Err(error) if error.kind() == ErrorKind::UnexpectedEof => Err(self.wrong()),
            Err(error) => Err((self.part, said(&error))),
        }
    }

    pub(super) fn byte(&mut self) -> Result<u8, Wrong> {
        self.take().map(|[byte]| byte)
    }

    /// Passes over bytes that are the same in every dump.
    pub(super) fn expect<const N: usize>(&mut self, known: &[u8; N]) -> Result<(), Wrong> {
        match self.take::<N>()? == *known {
            true => Ok(()),
            false => Err(self.wrong()),
        }
    }

    /// A number of four bytes.
    pub(super) fn word(&mut self) -> Result<u32, Wrong> {
        let bytes = self.take()?;
        Ok(match self.is_big_endian {
            true => u32::from_be_bytes(bytes),
            false => u32::from_le_bytes(bytes),
        })
    }

    /// A number of eight bytes with a sign.
    pub(super) fn wide(&mut self) -> Result<i64, Wrong> {
        let bytes = self.take()?;
        Ok(match self.is_big_endian {
            true => i64::from_be_bytes(bytes),
            false => i64::from_le_bytes(bytes),
        })
    }

    /// A number in LEB128.
    pub(super) fn number(&mut self) -> Result<u64, Wrong> {
        leb128::unsigned(|| self.byte())?.ok_or_else(|| self.wrong())
    }

    /// A number with a sign, in LEB128.
    pub(super) fn signed(&mut self) -> Result<i64, Wrong> {
        leb128::signed(|| self.byte())?.ok_or_else(|| self.wrong())
    }

    /// Expects the end of the file.
    pub(super) fn end(&mut self) -> Result<(), Wrong> {
        match self.input.fill_buf() {
            Ok([]) => Ok(()),
            Ok(_) => Err(self.wrong()),
            Err(error) => Err((self.part, said(&error))),
        }
    }
}
