//! The log format of can-utils' `candump -l`: `(1436509052.249713) can0 104#938406805591BB0C`.
//!
//! Text to frames and back with exact microseconds, nothing else: no files, no clock. Only classic data
//! frames with 11-bit identifiers are frames here; the other kinds that candump knows are counted.

use palpate_core::codec::can::CanFrame;
use palpate_core::units::Instant;

/// One line of a log.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Logged {
    /// Time of the line, microseconds: since the start of a run or since 1970, as the log was made.
    pub at: Instant,
    /// The interface's name.
    pub interface: String,
    /// The frame.
    pub frame: CanFrame,
}

/// Why a log cannot be read: the line (from 1) and what was expected there.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("line {line}: expected {expected}")]
pub struct Malformed {
    /// Line number, from 1.
    pub line: usize,
    /// Content that was expected.
    pub expected: &'static str,
    /// Frames in the lines before it.
    pub before: usize,
}

/// A log's frames in the order of its lines, and how many lines held another kind of frame
/// (29-bit, remote, error, CAN FD).
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Log {
    /// Classic data frames with 11-bit identifiers.
    pub frames: Vec<Logged>,
    /// Lines passed over.
    pub other_kinds: usize,
    /// The last line, where the log was cut in the middle of it; it is left out.
    pub cut: Option<usize>,
}

/// Appends one line. By hand: a full hand of boards writes 24,000 a second, and formatting takes most of it.
pub fn write_line(out: &mut String, at: Instant, interface: &str, frame: &CanFrame) {
    let us = at.as_micros();
    out.push('(');
    decimal(out, us / 1_000_000, 10);
    out.push('.');
    decimal(out, us % 1_000_000, 6);
    out.push_str(") ");
    out.push_str(interface);
    out.push(' ');
    let digit = |nibble: u16| char::from(b"0123456789ABCDEF"[usize::from(nibble & 0xf)]);
    let id = frame.id();
    out.extend([digit(id >> 8), digit(id >> 4), digit(id), '#']);
    for &byte in frame.data() {
        out.extend([digit(u16::from(byte) >> 4), digit(u16::from(byte))]);
    }
    out.push('\n');
}

/// A number with at least `width` digits.
fn decimal(out: &mut String, mut value: u64, width: usize) {
    let mut digits = [b'0'; 20];
    let mut start = digits.len();
    while value > 0 || digits.len() - start < width {
        start -= 1;
        digits[start] = b'0' + (value % 10) as u8;
        value /= 10;
    }
    out.extend(digits[start..].iter().map(|d| char::from(*d)));
}

/// Reads a whole log, or what a killed logger left of one. Empty lines are passed over; a trailing direction
/// (`R` or `T`) is accepted.
pub fn read(text: &str) -> Result<Log, Malformed> {
    let mut log = Log::default();
    for (n, line) in text.lines().enumerate() {
        if line.trim().is_empty() {
            continue;
        }
        let is_last = || text.ends_with(line);
        match read_line(line) {
            Ok(Some(logged)) => log.frames.push(logged),
            Ok(None) => log.other_kinds += 1,
            Err(_) if is_cut(line) && !log.frames.is_empty() && is_last() => {
                log.cut = Some(n + 1);
            }
            Err(expected) => {
                return Err(Malformed {
                    line: n + 1,
                    expected,
                    before: log.frames.len(),
                });
            }
        }
    }
    Ok(log)
}

/// Tells whether a malformed last line may be one that was cut.
#[must_use]
pub fn is_cut(line: &str) -> bool {
    line.starts_with('(')
}

/// Reads one line; `None` for a frame of another kind.
///
/// # Errors
/// The content that was expected in place of the line.
pub fn read_line(line: &str) -> Result<Option<Logged>, &'static str> {
    const SHAPE: &str = "`(seconds.microseconds) interface id#data`";
    let mut words = line.split_whitespace();
    let (Some(time), Some(interface), Some(frame)) = (words.next(), words.next(), words.next())
    else {
        return Err(SHAPE);
    };
    if !matches!((words.next(), words.next()), (None | Some("R" | "T"), None)) {
        return Err("nothing after the frame but R or T");
    }
    let at = time_of(time).ok_or("a time `(seconds.microseconds)` with six decimals")?;
    let (id, data) = frame.split_once('#').ok_or(SHAPE)?;
    let hex = |text: &str| !text.is_empty() && text.bytes().all(|b| b.is_ascii_hexdigit());
    if !hex(id) || !matches!(id.len(), 3 | 8) {
        return Err("an identifier of three or eight hexadecimal digits");
    }
    if id.len() == 8 || data.starts_with(['#', 'R', 'r']) {
        return Ok(None);
    }
    let id = u16::from_str_radix(id, 16).map_err(|_| SHAPE)?;
    let bytes = bytes_of(data).ok_or("up to eight bytes of two hexadecimal digits")?;
    let frame = CanFrame::new(id, &bytes).ok_or("an identifier up to 7FF and up to eight bytes")?;
    Ok(Some(Logged {
        at,
        interface: interface.to_owned(),
        frame,
    }))
}

/// `(seconds.microseconds)` without a detour through floating point, which would lose microseconds.
fn time_of(word: &str) -> Option<Instant> {
    let (seconds, micros) = word.strip_prefix('(')?.strip_suffix(')')?.split_once('.')?;
    let digits = |text: &str| !text.is_empty() && text.bytes().all(|b| b.is_ascii_digit());
    if !digits(seconds) || !digits(micros) || micros.len() != 6 {
        return None;
    }
    let seconds: u64 = seconds.parse().ok()?;
    let us = seconds.checked_mul(1_000_000)?;
    Some(Instant::from_micros(us.checked_add(micros.parse().ok()?)?))
}

fn bytes_of(text: &str) -> Option<Vec<u8>> {
    let pairs = text.as_bytes().chunks(2);
    pairs
        .map(|pair| match *pair {
            [high, low] => {
                let digit = |byte| char::from(byte).to_digit(16);
                Some((digit(high)? << 4 | digit(low)?) as u8)
            }
            _ => None,
        })
        .collect()
}

#[cfg(test)]
#[path = "candump_tests.rs"]
mod tests;
