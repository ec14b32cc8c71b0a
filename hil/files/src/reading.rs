//! Files opened to be read: ordinary ones or streams of this program, whole within a bound or line by line.
//!
//! Every reader of a user's file begins here. A file that never ends, waits for a writer or holds no text is refused
//! before it takes memory or time.

use std::fmt;
use std::fs::File;
use std::io::{self, BufRead, BufReader, Read};
use std::path::{Path, PathBuf};

use memchr::{memchr, memchr_iter};

use super::dialect::{has_row, is_remark};
use super::error::{FileError, said};
use super::format::Format;

/// Longest settings file, bytes. The largest that ships has 40 KiB.
pub const MOST_SETTINGS: u64 = 2 << 20;
/// Longest line of a text, bytes, where its columns do not ask for more.
pub const LONGEST_LINE: usize = 1 << 20;
/// Most values of a table that is held as a whole: six hours of 48 columns at 40 Hz.
pub const MOST_VALUES: usize = 40 << 20;
/// Longest run of NUL bytes that counts as the tail of a power cut.
const MOST_NULS: u64 = 64 << 20;
/// Bytes at the start of a file that tell its format.
const START: usize = 4096;

/// Opens an ordinary file, or a stream that this program was started with (`/dev/stdin`, `<(...)` of a shell).
///
/// # Errors
/// `expected` with what is there instead: nothing, a folder, a device, a pipe with a name, or a file of another user.
pub fn open(path: &Path, expected: &str) -> Result<File, FileError> {
    let label = path.display().to_string();
    let wrong = |found: String| FileError::whole(&label, expected, found);
    let there = std::fs::metadata(path).map_err(|e| wrong(said(&e)))?;
    if there.is_dir() {
        return Err(wrong("a folder".into()));
    }
    let piped = is_stream(path);
    if !there.is_file() && !piped {
        return Err(wrong(
            "a device, a socket or a pipe with a name (a pipe comes in as /dev/stdin)".into(),
        ));
    }
    let file = File::open(path).map_err(|e| wrong(said(&e)))?;
    // `/dev/stdin` may be a terminal or `/dev/zero`.
    let opened = file.metadata().map_err(|e| wrong(said(&e)))?;
    if piped && is_device(&opened) {
        return Err(wrong("a terminal or a device".into()));
    }
    Ok(file)
}

/// The entries of a folder, in the order of their names.
///
/// # Errors
/// A folder that cannot be read.
pub fn entries(folder: &Path) -> Result<Vec<PathBuf>, FileError> {
    let read = || -> io::Result<Vec<PathBuf>> {
        let entries = std::fs::read_dir(folder)?;
        entries.map(|entry| Ok(entry?.path())).collect()
    };
    let mut paths = read().map_err(|e| {
        let label = folder.display().to_string();
        FileError::whole(label, "a readable folder", said(&e))
    })?;
    paths.sort_unstable();
    Ok(paths)
}

/// Returns true if a path names an open stream of this program.
#[must_use]
pub fn is_stream(path: &Path) -> bool {
    [
        "/dev/stdin",
        "/dev/stdout",
        "/dev/stderr",
        "/dev/fd",
        "/proc/self/fd",
    ]
    .iter()
    .any(|stream| path.starts_with(stream))
}

#[cfg(unix)]
fn is_device(there: &std::fs::Metadata) -> bool {
    use std::os::unix::fs::FileTypeExt;
    let kind = there.file_type();
    kind.is_char_device() || kind.is_block_device()
}

#[cfg(not(unix))]
fn is_device(_there: &std::fs::Metadata) -> bool {
    false
}

/// Reads a whole file of at most `most` bytes.
///
/// # Errors
/// The errors of [`open`], and a file that is longer.
pub fn read_bytes(path: &Path, expected: &str, most: u64) -> Result<Vec<u8>, FileError> {
    let label = path.display().to_string();
    let file = open(path, expected)?;
    let long = |bytes: String| {
        let expected = format!("{expected} of at most {most} bytes");
        FileError::whole(&label, expected, bytes)
    };
    let wrong = |e: io::Error| FileError::whole(&label, expected, said(&e));
    let length = file.metadata().map_err(wrong)?.len();
    if length > most {
        return Err(long(format!("{length} bytes")));
    }
    let mut bytes = Vec::new();
    // A pipe has no length, and a file may grow.
    file.take(most + 1).read_to_end(&mut bytes).map_err(wrong)?;
    if bytes.len() as u64 > most {
        return Err(long("more".into()));
    }
    Ok(bytes)
}

/// Reads a whole text of at most `most` bytes.
///
/// # Errors
/// The errors of [`read_bytes`], and the line of the first byte that is no UTF-8.
pub fn read_text(path: &Path, expected: &str, most: u64) -> Result<String, FileError> {
    let bytes = read_bytes(path, expected, most)?;
    let label = path.display().to_string();
    if let Some(format) = Format::recognise(&bytes).filter(|f| !f.is_text()) {
        return Err(FileError::whole(label, expected, format.noun()));
    }
    String::from_utf8(bytes).map_err(|error| {
        let good = error.utf8_error().valid_up_to();
        let (before, rest) = error.as_bytes().split_at(good);
        FileError {
            line: Some(1 + before.iter().filter(|b| **b == b'\n').count()),
            ..FileError::whole(
                label,
                "UTF-8 text",
                format!("byte 0x{:02X}", rest.first().unwrap_or(&0)),
            )
        }
    })
}

/// The format of an ordinary file by its first bytes; none for a stream, which can be read only once, and for a file
/// that cannot be read.
#[must_use]
pub fn format_of(path: &Path) -> Option<Format> {
    if is_stream(path) {
        return None;
    }
    let mut start = Vec::new();
    let file = open(path, "").ok()?;
    file.take(START as u64).read_to_end(&mut start).ok()?;
    Format::recognise(&start)
}

/// Bytes of a text without a byte order mark. No line is longer than allowed, and a tail of NULs, as a power cut
/// leaves one, is held back with its line.
pub struct Text<R> {
    label: String,
    input: R,
    longest: usize,
    /// The line under way, from 1, and its length so far.
    line: usize,
    length: usize,
    /// Number of NULs that were held back, and a flag that text came before them.
    nuls: u64,
    begun: bool,
    /// True where the first read waits for a full beginning, and not for a row alone.
    waits: bool,
    /// Error behind a beginning that is read first.
    wrong: Option<io::Error>,
}

impl<R> fmt::Debug for Text<R> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Text")
            .field("label", &self.label)
            .field("line", &self.line)
            .finish_non_exhaustive()
    }
}

impl Text<File> {
    /// Opens a text whose lines have at most `longest` bytes.
    ///
    /// # Errors
    /// The errors of [`open`].
    pub fn open(path: &Path, expected: &str, longest: usize) -> Result<Self, FileError> {
        if let Some(format) = format_of(path).filter(|f| !f.is_text()) {
            let label = path.display().to_string();
            return Err(FileError::whole(label, expected, format.noun()));
        }
        let file = open(path, expected)?;
        Ok(Self::new(path.display().to_string(), file, longest))
    }
}

impl<R: Read> Text<R> {
    /// A text from any reader; `label` names it in errors.
    pub fn new(label: impl Into<String>, input: R, longest: usize) -> Self {
        Self {
            label: label.into(),
            input,
            longest,
            line: 1,
            length: 0,
            nuls: 0,
            begun: false,
            waits: false,
            wrong: None,
        }
    }

    /// The text with as much of its beginning as a reader holds, however small the pieces of a pipe are: it tells how the rest is
    /// written. A live stream waits for its first row alone.
    #[must_use]
    pub fn waiting(self) -> Self {
        Self {
            waits: true,
            ..self
        }
    }

    /// Note on a tail of NULs, once the end is reached.
    #[must_use]
    pub fn note(&self) -> Option<String> {
        (self.nuls > 0).then(|| {
            format!(
                "{}:{}: the file ends in {} NUL bytes, as after a power cut; what stands before them was read",
                self.label, self.line, self.nuls
            )
        })
    }

    /// Reads until `out` is full, the input ends, or there is a row where the text does not wait for more.
    fn begin(&mut self, out: &mut [u8]) -> io::Result<usize> {
        let mut filled = 0;
        while filled < out.len() {
            match self.input.read(&mut out[filled..]) {
                Ok(0) => break,
                Ok(read) => {
                    let ends_line = memchr(b'\n', &out[filled..filled + read]).is_some();
                    filled += read;
                    if ends_line && !self.waits && has_row(&out[..filled]) {
                        break;
                    }
                }
                Err(error) if error.kind() == io::ErrorKind::Interrupted => {}
                Err(error) if filled == 0 => return Err(error),
                Err(error) => {
                    self.wrong = Some(error);
                    break;
                }
            }
        }
        Ok(filled)
    }

    fn refuse(&self, expected: String, found: String) -> io::Error {
        io::Error::other(FileError {
            line: Some(self.line),
            ..FileError::whole(&self.label, expected, found)
        })
    }

    /// Checks bytes that were read; returns the number of them that are text.
    fn look(&mut self, bytes: &[u8]) -> io::Result<usize> {
        if self.nuls == 0 && memchr(0, bytes).is_none() {
            return self.look_at_lines(bytes);
        }
        let mut text = 0;
        for piece in bytes.split_inclusive(|b| *b == b'\n' || *b == 0) {
            if piece == [0] || piece.ends_with(&[0]) {
                let before = piece.len() - 1;
                if before > 0 && self.nuls > 0 {
                    return Err(self.amid());
                }
                text += before;
                self.length += before;
                self.begun |= before > 0;
                self.nuls += 1;
                if !self.begun || self.nuls > MOST_NULS {
                    let found = format!("{} NUL bytes or more", self.nuls);
                    return Err(self.refuse("a text".into(), found));
                }
                continue;
            }
            if self.nuls > 0 {
                return Err(self.amid());
            }
            self.begun = true;
            self.length += piece.len();
            if self.length > self.longest {
                let expected = format!("a line of at most {} bytes", self.longest);
                return Err(self.refuse(expected, "a longer one".into()));
            }
            text += piece.len();
            if piece.ends_with(b"\n") {
                self.line += 1;
                self.length = 0;
            }
        }
        Ok(text)
    }

    /// Looks at bytes without a NUL among them or before them.
    fn look_at_lines(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.begun |= !bytes.is_empty();
        let mut begin = 0;
        let ends = memchr_iter(b'\n', bytes).map(|end| end + 1);
        for end in ends.chain([bytes.len()]) {
            self.length += end - begin;
            if self.length > self.longest {
                let expected = format!("a line of at most {} bytes", self.longest);
                return Err(self.refuse(expected, "a longer one".into()));
            }
            if end > begin && bytes[end - 1] == b'\n' {
                self.line += 1;
                self.length = 0;
            }
            begin = end;
        }
        Ok(bytes.len())
    }

    fn amid(&self) -> io::Error {
        let found = format!("{} NUL bytes in the middle of the file", self.nuls);
        self.refuse("text".into(), found)
    }
}

impl<R: Read> Read for Text<R> {
    fn read(&mut self, out: &mut [u8]) -> io::Result<usize> {
        loop {
            if let Some(error) = self.wrong.take() {
                return Err(error);
            }
            let first = self.line == 1 && self.length == 0 && !self.begun;
            let mut read = match first {
                true => self.begin(out)?,
                false => self.input.read(out)?,
            };
            if read == 0 {
                return Ok(0);
            }
            if first && out[..read].starts_with(b"\xEF\xBB\xBF") {
                out.copy_within(3..read, 0);
                read -= 3;
                if read == 0 {
                    self.begun = true;
                    continue;
                }
            }
            let text = self.look(&out[..read])?;
            if text > 0 {
                return Ok(text); // NULs stand behind it
            }
        }
    }
}

impl FileError {
    /// The error of reading a [`Text`]: its own refusal, or the system's message.
    #[must_use]
    pub fn of_io(label: &str, expected: &str, error: io::Error) -> Self {
        let own = error.get_ref().and_then(|e| e.downcast_ref::<Self>());
        own.cloned()
            .unwrap_or_else(|| Self::whole(label, expected, said(&error)))
    }
}

/// A text line by line.
#[derive(Debug)]
pub struct Lines<R> {
    text: BufReader<Text<R>>,
    line: Vec<u8>,
    number: usize,
}

impl Lines<File> {
    /// Opens the lines of a [`Text::open`].
    ///
    /// # Errors
    /// The errors of [`open`].
    pub fn open(path: &Path, expected: &str, longest: usize) -> Result<Self, FileError> {
        Ok(Self::over(Text::open(path, expected, longest)?))
    }
}

impl<R: Read> Lines<R> {
    /// The lines of a text.
    pub fn over(text: Text<R>) -> Self {
        Self {
            text: BufReader::with_capacity(1 << 16, text),
            line: Vec::new(),
            number: 0,
        }
    }

    /// Name of the file in errors.
    #[must_use]
    pub fn label(&self) -> &str {
        &self.text.get_ref().label
    }

    /// The format of the text that has not been read yet.
    ///
    /// # Errors
    /// The errors of [`Lines::advance`].
    pub fn format(&mut self) -> Result<Option<Format>, FileError> {
        let start = self.text.fill_buf().map(Format::recognise);
        start.map_err(|e| FileError::of_io(self.label(), "a readable file", e))
    }

    /// The text at hand that was not read yet, up to the first byte that is no text.
    ///
    /// # Errors
    /// The errors of [`Lines::advance`].
    pub(super) fn start(&mut self) -> Result<&str, FileError> {
        let label = self.text.get_ref().label.clone();
        let start = self.text.fill_buf();
        let start = start.map_err(|e| FileError::of_io(&label, "a readable file", e))?;
        let text = start.utf8_chunks().next();
        Ok(text.map_or("", |chunk| chunk.valid()))
    }

    /// The next line with content that is no remark, from [`Lines::advance`].
    ///
    /// # Errors
    /// The errors of [`Lines::advance`].
    pub(super) fn next_row(&mut self) -> Result<Option<(usize, &str)>, FileError> {
        while self.fetch()? {
            if !is_remark(&self.line) {
                return self.text_of_line().map(Some);
            }
        }
        Ok(None)
    }

    /// The next line and its number, from 1, without its end; none at the end of the text. The
    /// line that NULs cut short is left out.
    ///
    /// # Errors
    /// A line that is too long or no UTF-8, NULs before the end, and the system's error.
    pub fn advance(&mut self) -> Result<Option<(usize, &str)>, FileError> {
        match self.fetch()? {
            true => self.text_of_line().map(Some),
            false => Ok(None),
        }
    }

    /// Reads the next line into `line`; false at the end.
    fn fetch(&mut self) -> Result<bool, FileError> {
        self.line.clear();
        let read = self.text.read_until(b'\n', &mut self.line);
        let read = read.map_err(|e| FileError::of_io(self.label(), "a readable file", e))?;
        let torn = !self.line.ends_with(b"\n") && self.text.get_ref().nuls > 0;
        if read == 0 || torn {
            return Ok(false);
        }
        self.number += 1;
        Ok(true)
    }

    fn text_of_line(&self) -> Result<(usize, &str), FileError> {
        let line = self.line.as_slice();
        match std::str::from_utf8(line) {
            Ok(line) => Ok((self.number, line.trim_end_matches(['\n', '\r']))),
            Err(error) => Err(FileError {
                line: Some(self.number),
                ..FileError::whole(
                    self.label(),
                    "UTF-8 text",
                    format!("byte 0x{:02X}", line[error.valid_up_to()]),
                )
            }),
        }
    }

    /// Returns true if the line that was read last has no end: the file may have been cut in it.
    #[must_use]
    pub fn is_unfinished(&self) -> bool {
        !self.line.ends_with(b"\n")
    }

    /// Note of the text, [`Text::note`].
    #[must_use]
    pub fn note(&self) -> Option<String> {
        self.text.get_ref().note()
    }
}

#[cfg(test)]
#[path = "reading_tests.rs"]
mod tests;
