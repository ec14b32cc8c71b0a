//! FST dumps, the packed waveforms that GTKWave's library writes for simulators.
//!
//! A dump has blocks: a header, sections of changes, the widths of all signals, and their names. A section is read signal by signal,
//! so that the memory is that of its times and of one signal. Only signals of one bit are unpacked. Any damage is an error, because
//! the names stand at the end of the file.

mod bytes;
mod hierarchy;
mod section;

use std::io::{Cursor, Read, Seek};

use palpate_files::FileError;

use self::bytes::{Bytes, MOST_PART, Packing, Source, perhaps_zlib};
use self::section::{Change, Section};
use super::declared::{Declared, Wrong, damaged};
use super::dump::level;
use super::edges::Capture;
use super::{MOST_CHANGES, too_long};

/// Kinds of blocks, by the format's numbers.
const HEADER: u8 = 0;
const BLACKOUT: u8 = 2;
const WIDTHS: u8 = 3;
const NAMES: [u8; 3] = [4, 6, 7];
const SECTIONS: [u8; 3] = [1, 5, 8];
const SKIPPED: u8 = 255;
/// The whole dump, packed.
const PACKED: u8 = 254;
/// Length of a header, bytes.
const HEADER_LENGTH: u64 = 329;

/// A block: its kind, the offset behind the kind, and its length.
type Block = (u8, u64, u64);

/// A signal that is read.
#[derive(Debug)]
struct Wanted {
    handle: u64,
    place: usize,
    /// Place of its letter among the values at the beginning.
    letter_at: usize,
}

/// A dump as far as it was read.
struct Dump<R> {
    source: Source<R>,
    declared: Declared<u64>,
    wanted: Vec<Wanted>,
    handles: u64,
    clock: Clock,
    changes: usize,
}

/// Ticks as nanoseconds.
#[derive(Clone, Copy, Debug)]
struct Clock {
    /// Length of a tick: numerator and denominator of nanoseconds.
    tick: (u64, u64),
    zero: u64,
    /// The last time of the dump, ticks.
    end: u64,
    sections: u64,
}

impl Clock {
    /// Reads a header.
    fn read(header: &[u8]) -> Option<Self> {
        let mut header = Bytes(header);
        header.take(8)?;
        let (zero, end) = (header.wide()?, header.wide()?);
        header.take(5 * 8)?;
        let sections = header.wide()?;
        let exponent = i8::from_be_bytes([header.byte()?]);
        let power = (-15..=2).contains(&exponent).then(|| exponent + 9)?;
        let factor = 10_u64.pow(power.unsigned_abs().into());
        Some(Self {
            tick: if power < 0 { (1, factor) } else { (factor, 1) },
            zero,
            end,
            sections,
        })
    }

    fn ns(&self, ticks: u64) -> u64 {
        let since = u128::from(ticks.saturating_sub(self.zero));
        let ns = since * u128::from(self.tick.0) / u128::from(self.tick.1);
        u64::try_from(ns).unwrap_or(u64::MAX)
    }
}

/// Reads a dump.
///
/// # Errors
/// [`FileError`] for a damaged or unfinished dump, and more changes than are held.
pub(super) fn read(label: &str, input: impl Read + Seek) -> Result<Capture, FileError> {
    let told = |(expected, found): Wrong| FileError::whole(label, expected, found);
    let mut source = Source::new(input).map_err(told)?;
    match unpacked(&mut source).map_err(told)? {
        Some(plain) => read_plain(label, Source::new(Cursor::new(plain)).map_err(told)?),
        None => read_plain(label, source),
    }
}

/// The dump within one that is packed as a whole, as GHDL writes it; none for any other.
fn unpacked(source: &mut Source<impl Read + Seek>) -> Result<Option<Vec<u8>>, Wrong> {
    let wrong = || damaged("a whole dump, packed by gzip");
    if source.part(0, 1)? != [PACKED] {
        return Ok(None);
    }
    let part = source.part(1, source.length() - 1)?;
    let mut rest = Bytes(&part);
    let (length, plain) = (rest.wide(), rest.wide().ok_or_else(wrong)?);
    if plain > MOST_PART {
        let found = format!("{plain} (fst2vcd FILE.fst > FILE.vcd)");
        return Err(("a packed dump of at most 64 MiB", found));
    }
    let plain = Packing::Gzip.unpack(rest.0, plain);
    let plain = plain.filter(|_| length == Some(part.len() as u64));
    plain.map(Some).ok_or_else(wrong)
}

fn read_plain(label: &str, mut source: Source<impl Read + Seek>) -> Result<Capture, FileError> {
    let told = |(expected, found): Wrong| FileError::whole(label, expected, found);
    let blocks = blocks(&mut source).map_err(told)?;
    let switched = switched(&mut source, &blocks).map_err(told)?;
    let mut dump = Dump::declared(source, &blocks).map_err(told)?;
    let mut last = None;
    for block in blocks.iter().filter(|block| SECTIONS.contains(&block.0)) {
        last = Some(dump.section(*block, last).map_err(told)?);
        if dump.changes > MOST_CHANGES {
            return Err(too_long(label, None));
        }
    }
    let clock = dump.clock;
    if last != Some(clock.end) {
        return Err(told(damaged(
            "changes up to the time that the header states",
        )));
    }
    let (resolution_ns, end_ns) = (clock.tick.0 / clock.tick.1, clock.ns(clock.end));
    let mut capture = Capture::of_dump(dump.declared.signals, resolution_ns, end_ns);
    let mut off = None;
    for (tick, is_on) in switched {
        match is_on {
            false => off = off.or(Some(clock.ns(tick))),
            true => capture
                .unrecorded
                .extend(off.take().map(|from| (from, clock.ns(tick)))),
        }
    }
    capture.unrecorded.extend(off.map(|from| (from, end_ns)));
    Ok(capture)
}

/// Blocks up to the end of the file.
fn blocks(source: &mut Source<impl Read + Seek>) -> Result<Vec<Block>, Wrong> {
    let (mut at, mut blocks) = (0, Vec::new());
    while at < source.length() {
        let head = source.part(at, 9)?;
        let mut head = Bytes(&head);
        let (kind, length) = (head.byte(), head.wide());
        let end = length.and_then(|length| (at + 1).checked_add(length));
        let whole = end.filter(|end| *end > at + 8 && *end <= source.length());
        let (Some(kind), Some(length), Some(end)) = (kind, length, whole) else {
            return Err(damaged("blocks up to the end of the file"));
        };
        blocks.push((kind, at + 1, length));
        at = end;
    }
    let known = [HEADER, BLACKOUT, WIDTHS, SKIPPED].iter();
    let is_known = |kind| {
        known
            .clone()
            .chain(&NAMES)
            .chain(&SECTIONS)
            .any(|k| *k == kind)
    };
    match blocks.iter().all(|block| is_known(block.0)) {
        true => Ok(blocks),
        false => Err(damaged("blocks of known kinds")),
    }
}

/// The one block of these kinds.
fn only(blocks: &[Block], kinds: &[u8], expected: &'static str) -> Result<Block, Wrong> {
    let mut all = blocks.iter().filter(|block| kinds.contains(&block.0));
    match (all.next(), all.next()) {
        (Some(block), None) => Ok(*block),
        _ => Err(damaged(expected)),
    }
}

/// Times at which recording went off, and on again where it is true.
fn switched(
    source: &mut Source<impl Read + Seek>,
    blocks: &[Block],
) -> Result<Vec<(u64, bool)>, Wrong> {
    let mut switched = Vec::new();
    for (_, at, length) in blocks.iter().filter(|block| block.0 == BLACKOUT) {
        let part = source.part(*at, *length)?;
        let times = blackouts(&part).ok_or_else(|| damaged("whole times without a recording"))?;
        switched.extend(times);
    }
    Ok(switched)
}

fn blackouts(block: &[u8]) -> Option<Vec<(u64, bool)>> {
    let mut rest = Bytes(block);
    rest.wide()?;
    let (count, mut now, mut times) = (rest.number()?, 0_u64, Vec::new());
    while !rest.0.is_empty() {
        let is_on = rest.byte()? != 0;
        now = now.checked_add(rest.number()?)?;
        times.push((now, is_on));
    }
    (times.len() as u64 == count).then_some(times)
}

/// The names of a block.
fn names(kind: u8, part: &[u8]) -> Option<Vec<u8>> {
    let mut rest = Bytes(part);
    let (_, plain) = (rest.wide()?, rest.wide()?);
    match kind {
        4 => Packing::Gzip.unpack(rest.0, plain),
        6 => Packing::Lz4.unpack(rest.0, plain),
        _ => {
            let once = rest.number()?;
            let once = Packing::Lz4.unpack(rest.0, once)?;
            Packing::Lz4.unpack(&once, plain)
        }
    }
}

/// The widths of all signals, in letters.
fn widths(part: &[u8]) -> Option<Vec<u64>> {
    let mut rest = Bytes(part);
    let (_, plain, count) = (rest.wide()?, rest.wide()?, rest.wide()?);
    let plain = perhaps_zlib(rest.0.to_vec(), plain)?;
    let (mut rest, mut widths) = (Bytes(&plain), Vec::new());
    while !rest.0.is_empty() {
        widths.push(match rest.number()? {
            0 => 8, // a real
            0xffff_ffff => 0,
            width => width,
        });
    }
    (widths.len() as u64 == count).then_some(widths)
}

impl<R: Read + Seek> Dump<R> {
    /// Reads all but the sections.
    fn declared(mut source: Source<R>, blocks: &[Block]) -> Result<Self, Wrong> {
        let header = only(blocks, &[HEADER], "one header")?;
        let clock = match header.2 == HEADER_LENGTH {
            true => Clock::read(&source.part(header.1, header.2)?),
            false => None,
        };
        let clock = clock.ok_or_else(|| damaged("a header with a time scale from fs to 100 s"))?;
        let sections = blocks.iter().filter(|block| SECTIONS.contains(&block.0));
        if sections.count() as u64 != clock.sections {
            return Err(damaged("as many sections as the header states"));
        }
        let block = only(blocks, &NAMES, "one hierarchy of names")?;
        let part = source.part(block.1, block.2)?;
        let hierarchy = names(block.0, &part).ok_or_else(|| damaged("a whole hierarchy"))?;
        let (declared, handles) = hierarchy::declared(&hierarchy)?;
        let block = only(blocks, &[WIDTHS], "the widths of all signals")?;
        let part = source.part(block.1, block.2)?;
        let widths = widths(&part).filter(|all| all.len() as u64 == handles);
        let widths = widths.ok_or_else(|| damaged("the width of each signal"))?;
        let (mut wanted, mut letter_at) = (Vec::new(), 0_u64);
        for (handle, width) in (1..).zip(widths) {
            if let Some(place) = declared.place(&handle) {
                if width != 1 {
                    return Err(damaged("signals as wide as their variables"));
                }
                let letter_at = usize::try_from(letter_at).unwrap_or(usize::MAX);
                wanted.push(Wanted {
                    handle,
                    place,
                    letter_at,
                });
            }
            letter_at = letter_at.saturating_add(width);
        }
        Ok(Self {
            source,
            declared,
            wanted,
            handles,
            clock,
            changes: 0,
        })
    }

    /// Reads the changes of a section behind one that ended at `last`, and gives its end.
    fn section(&mut self, (kind, at, length): Block, last: Option<u64>) -> Result<u64, Wrong> {
        let is_newest = kind == SECTIONS[2];
        let section = Section::read(&mut self.source, (at, length), is_newest, self.handles)?;
        let is_first = last.is_none();
        let begins = last.unwrap_or(section.start);
        let is_ordered = begins <= section.start && section.start <= section.end;
        let first = section.times.first().unwrap_or(&section.start);
        let last = section.times.last().unwrap_or(&section.end);
        if !is_ordered || *first < begins || *last > section.end {
            return Err(damaged("sections and times in their order"));
        }
        if is_first {
            self.clock.zero = section.start;
        }
        // Signals that change alike share a piece, which is read once.
        let pieces = self
            .wanted
            .iter()
            .map(|wanted| section.piece_of(wanted.handle));
        let mut order: Vec<_> = pieces.zip(0..).collect();
        order.sort_unstable();
        let (mut read, mut changes) = (0, Vec::new());
        for (piece, index) in order {
            if piece != read {
                changes = section.changes(&mut self.source, piece)?;
                read = piece;
            }
            let own = if piece == 0 { &[][..] } else { &changes };
            self.take(&section, index, own, is_first)?;
            if self.changes > MOST_CHANGES {
                break;
            }
        }
        Ok(section.end)
    }

    /// Takes the changes of a signal, and in the first section its level at the beginning, unless it changes right there.
    fn take(
        &mut self,
        section: &Section,
        index: usize,
        changes: &[Change],
        is_first: bool,
    ) -> Result<(), Wrong> {
        let wanted = &self.wanted[index];
        let signal = &mut self.declared.signals[wanted.place];
        let time = |change: &Change| section.times[change.0 as usize];
        let changes_there = changes
            .first()
            .is_some_and(|first| time(first) == section.start);
        if is_first && !changes_there {
            let letter = section.frame.get(wanted.letter_at).copied().and_then(level);
            let level = letter.ok_or_else(|| damaged("a level of each signal at the beginning"))?;
            self.changes += usize::from(signal.change(0, level));
        }
        for change in changes {
            signal.change(self.clock.ns(time(change)), change.1);
        }
        self.changes += changes.len();
        Ok(())
    }
}

#[cfg(test)]
mod tests;
