//! Formats of can-utils' `candump`: the log `(1436509052.249713) can0 104#938406805591BB0C` of `-l` and `-L`, and the
//! columns `(1436509052.249713)  can0  104   [8]  93 84 06 80 55 91 BB 0C` of a terminal.
//!
//! Text to frames and back with exact microseconds, nothing else: no files, no clock. Only classic data
//! frames with 11-bit identifiers are frames here; the other kinds that candump knows are counted, as are the frames
//! that it says were dropped and the remarks that `canplayer` passes over.

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

/// Refusal of a log: the line (from 1) and what was expected there.
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

/// Content of a line of a log.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Line {
    /// A classic data frame with an 11-bit identifier.
    Frame(Logged),
    /// Something that is counted and not kept.
    Beside(Beside),
}

/// Lines that hold no classic data frame with an 11-bit identifier.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Beside {
    /// Frames of another kind: 29-bit, remote, error, CAN FD, CAN XL.
    pub other_kinds: usize,
    /// Frames that the logger's socket dropped, by its `DROPCOUNT` lines.
    pub dropped: u64,
    /// Remarks: lines that begin with neither a time nor an interface.
    pub remarks: usize,
}

impl Beside {
    const OTHER_KIND: Line = Line::Beside(Self {
        other_kinds: 1,
        ..Self::NONE
    });
    const REMARK: Line = Line::Beside(Self {
        remarks: 1,
        ..Self::NONE
    });
    const NONE: Self = Self {
        other_kinds: 0,
        dropped: 0,
        remarks: 0,
    };

    /// Counts the lines of both.
    pub const fn add(&mut self, other: Self) {
        self.other_kinds += other.other_kinds;
        self.dropped = self.dropped.saturating_add(other.dropped);
        self.remarks += other.remarks;
    }

    /// A sentence's parts for people; none where there is nothing to say.
    #[must_use]
    pub fn words(&self) -> Option<String> {
        let mut parts = Vec::new();
        if self.dropped > 0 {
            parts.push(format!("{} frames were lost to the logger", self.dropped));
        }
        if self.other_kinds > 0 {
            parts.push(format!(
                "{} frames of another kind (29-bit, remote, error, CAN FD, CAN XL) were passed over",
                self.other_kinds
            ));
        }
        if self.remarks > 0 {
            parts.push(match self.remarks {
                1 => "1 remark was passed over".to_owned(),
                n => format!("{n} remarks were passed over"),
            });
        }
        (!parts.is_empty()).then(|| parts.join(", "))
    }
}

/// A log's frames in the order of its lines, and what it holds beside them.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Log {
    /// Classic data frames with 11-bit identifiers.
    pub frames: Vec<Logged>,
    /// Lines passed over.
    pub beside: Beside,
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
            Ok(Line::Frame(logged)) => log.frames.push(logged),
            Ok(Line::Beside(beside)) => log.beside.add(beside),
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

/// One line.
///
/// # Errors
/// What was expected in its place.
pub fn read_line(line: &str) -> Result<Line, &'static str> {
    let line = line.trim_start();
    if let Some(dropped) = line.strip_prefix("DROPCOUNT:") {
        let count = dropped.split_whitespace().find_map(|w| w.parse().ok());
        let dropped = count.ok_or("a number of frames after DROPCOUNT")?;
        return Ok(Line::Beside(Beside {
            dropped,
            ..Beside::NONE
        }));
    }
    let (time, rest) = match line.strip_prefix('(') {
        Some(timed) => {
            let (time, rest) = timed.split_once(')').ok_or(SHAPE)?;
            (Some(time), rest)
        }
        None => (None, line),
    };
    let mut words = rest.split_whitespace().peekable();
    let interface = words.next().unwrap_or_default();
    let second = words.next().unwrap_or_default();
    // `candump -x` says the direction and two flags before the frame.
    let id = match second {
        "RX" | "TX" if words.clone().any(is_length) => words.nth(2),
        _ => Some(second),
    };
    let in_columns = !second.contains('#') && words.peek().is_some_and(|w| is_length(w));
    let Some(time) = time else {
        let is_frame = in_columns || (second.contains('#') && compact(second).is_ok());
        return match is_frame {
            true => Err("a time before the frame (candump -L or candump -t a writes one)"),
            false => Ok(Beside::REMARK),
        };
    };
    let at = time_of(time).ok_or("a time `(seconds.microseconds)` with six or nine decimals")?;
    let frame = match in_columns {
        true => columns(id.unwrap_or_default(), words)?,
        false => {
            if !matches!((words.next(), words.next()), (None | Some("R" | "T"), None)) {
                return Err("nothing after the frame but R or T");
            }
            compact(second)?
        }
    };
    Ok(match frame {
        None => Beside::OTHER_KIND,
        Some(frame) => Line::Frame(Logged {
            at,
            interface: interface.to_owned(),
            frame,
        }),
    })
}

const SHAPE: &str = "`(seconds.microseconds) interface id#data`";

/// The frame of a log's line, `104#938406805591BB0C`; none of another kind.
fn compact(frame: &str) -> Result<Option<CanFrame>, &'static str> {
    let (id, data) = frame.split_once('#').ok_or(SHAPE)?;
    // CAN XL has its network in front of a priority, and three fields before its data.
    if id.len() == 5
        && data
            .split_once('#')
            .is_some_and(|(head, _)| head.contains(':'))
    {
        return Ok(None);
    }
    if !is_hex(id) || !matches!(id.len(), 3 | 8) {
        return Err("an identifier of three or eight hexadecimal digits");
    }
    if id.len() == 8 || data.starts_with(['#', 'R', 'r']) {
        return Ok(None);
    }
    // A raw length code above eight stands behind eight bytes.
    let data = match data.split_once('_') {
        Some((bytes, code)) if bytes.len() == 16 && code.len() == 1 && is_hex(code) => bytes,
        _ => data,
    };
    let bytes = bytes_of(data).ok_or("up to eight bytes of two hexadecimal digits")?;
    classic(id, &bytes).map(Some)
}

/// The frame of a terminal's line, `104 [8] 93 84 06 80 55 91 BB 0C`; none of another kind.
fn columns<'a>(
    id: &str,
    mut words: impl Iterator<Item = &'a str>,
) -> Result<Option<CanFrame>, &'static str> {
    if !is_hex(id) || !matches!(id.len(), 3 | 8) {
        return Err("an identifier of three or eight hexadecimal digits");
    }
    let length = words.next().unwrap_or_default();
    let inner = length.trim_matches(['[', ']', '{', '}']);
    // CAN FD has two digits, CAN XL four.
    if id.len() == 8 || inner.len() > 1 {
        return Ok(None);
    }
    let length = match usize::from_str_radix(inner, 16) {
        Ok(length) => length.min(8),
        Err(_) => return Err("a length between brackets"),
    };
    let data: Vec<&str> = words.take(length).collect();
    if data.first() == Some(&"remote") {
        return Ok(None);
    }
    let bytes = bytes_of(&data.concat()).filter(|bytes| bytes.len() == length);
    classic(id, &bytes.ok_or("as many bytes as the length says")?).map(Some)
}

fn classic(id: &str, bytes: &[u8]) -> Result<CanFrame, &'static str> {
    let id = u16::from_str_radix(id, 16).map_err(|_| SHAPE)?;
    CanFrame::new(id, bytes).ok_or("an identifier up to 7FF and up to eight bytes")
}

fn is_hex(text: &str) -> bool {
    !text.is_empty() && text.bytes().all(|b| b.is_ascii_hexdigit())
}

/// Returns true if a word is the length in a terminal's line: `[8]`, `[08]`, or `{F}` for a raw length code.
fn is_length(word: &str) -> bool {
    let inner = |open, close| word.strip_prefix(open)?.strip_suffix(close);
    inner('[', ']').or(inner('{', '}')).is_some_and(is_hex)
}

/// `seconds.microseconds`, or with nanoseconds, which are cut off: without a detour through floating point, which would
/// lose microseconds.
fn time_of(word: &str) -> Option<Instant> {
    let (seconds, fraction) = word.split_once('.')?;
    let digits = |text: &str| !text.is_empty() && text.bytes().all(|b| b.is_ascii_digit());
    if !digits(seconds) || !digits(fraction) || !matches!(fraction.len(), 6 | 9) {
        return None;
    }
    let seconds: u64 = seconds.parse().ok()?;
    let us = seconds.checked_mul(1_000_000)?;
    let micros = fraction.get(..6)?.parse().ok()?;
    Some(Instant::from_micros(us.checked_add(micros)?))
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
