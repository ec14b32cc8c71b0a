//! Text of a table that is made from another format while it is read.

use std::io::{self, Read};

use super::error::FileError;

/// Bytes of text that are made at once.
const CHUNK: usize = 1 << 16;

/// Maker of the lines of a table.
pub(super) trait Lines {
    /// Adds the next line, or lines; false at the end.
    ///
    /// # Errors
    /// The defect of the file.
    fn add(&mut self, text: &mut Vec<u8>) -> Result<bool, FileError>;
}

/// Reader of lines that are made meanwhile.
#[derive(Debug)]
pub(super) struct Made<L> {
    lines: L,
    text: Vec<u8>,
    taken: usize,
    /// Error behind lines that are read first.
    wrong: Option<FileError>,
}

impl<L> Made<L> {
    pub(super) const fn new(lines: L) -> Self {
        Self {
            lines,
            text: Vec::new(),
            taken: 0,
            wrong: None,
        }
    }
}

impl<L: Lines> Read for Made<L> {
    fn read(&mut self, out: &mut [u8]) -> io::Result<usize> {
        if self.taken == self.text.len() {
            self.text.clear();
            self.taken = 0;
            while self.wrong.is_none() && self.text.len() < CHUNK {
                match self.lines.add(&mut self.text) {
                    Ok(true) => {}
                    Ok(false) => break,
                    Err(wrong) => self.wrong = Some(wrong),
                }
            }
            if self.text.is_empty()
                && let Some(wrong) = self.wrong.take()
            {
                return Err(io::Error::other(wrong));
            }
        }
        let mut rest = &self.text[self.taken..];
        let read = rest.read(out)?;
        self.taken += read;
        Ok(read)
    }
}
