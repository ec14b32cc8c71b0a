//! A section of changes: values at its beginning, times, and the changes of each signal.

use std::io::{Read, Seek};

use super::super::MOST_CHANGES;
use super::super::declared::{Wrong, damaged};
use super::super::dump::level;
use super::bytes::{Bytes, Packing, Source, perhaps_zlib};

/// Most bytes of a few numbers in LEB128.
const NUMBERS: u64 = 40;
/// Bytes of the lengths behind the times.
const LENGTHS: u64 = 24;

/// A section as far as its signals share it.
#[derive(Debug)]
pub(super) struct Section {
    pub(super) start: u64,
    pub(super) end: u64,
    /// Values of all signals at the beginning, a letter for each bit.
    pub(super) frame: Vec<u8>,
    /// Ticks at which anything changes.
    pub(super) times: Vec<u64>,
    packing: Packing,
    /// The number of each handle's piece, 0 for none, and the places of the pieces in the file.
    piece_of: Vec<u32>,
    pieces: Vec<(u64, u64)>,
}

/// A change: the index of its time, and its level.
pub(super) type Change = (u32, Option<bool>);

impl Section {
    /// Reads what signals share of a section of `length` bytes at `at`. Only the newest format has signed numbers.
    pub(super) fn read(
        source: &mut Source<impl Read + Seek>,
        (at, length): (u64, u64),
        is_signed: bool,
        handles: u64,
    ) -> Result<Self, Wrong> {
        let wrong = || damaged("a section with whole tables");
        let (end_at, head_length) = (at + length, length.min(32 + NUMBERS));
        if length < 32 + LENGTHS {
            return Err(wrong());
        }
        let head = source.part(at, head_length)?;
        let mut head = Bytes(&head);
        let mut next = || head.wide().ok_or_else(wrong);
        let [_length, start, end, _memory] = [next()?, next()?, next()?, next()?];
        let begun = head;
        let mut next = || head.number().ok_or_else(wrong);
        let [plain, packed, _handles] = [next()?, next()?, next()?];
        let frame_at = at + 32 + (begun.0.len() - head.0.len()) as u64;

        let lengths = source.part(end_at - LENGTHS, LENGTHS)?;
        let mut lengths = Bytes(&lengths);
        let mut next = || lengths.wide().ok_or_else(wrong);
        let [plain_times, packed_times, count] = [next()?, next()?, next()?];

        let down = |from: u64, by: u64| from.checked_sub(by).filter(|to| *to > frame_at);
        let times_at = down(end_at - LENGTHS, packed_times).ok_or_else(wrong)?;
        let chain_end = down(times_at, 8).ok_or_else(wrong)?;
        let chain_length = source.part(chain_end, 8)?;
        let chain_length = Bytes(&chain_length).wide().ok_or_else(wrong)?;
        let chain_at = down(chain_end, chain_length).ok_or_else(wrong)?;
        let data_at = frame_at
            .checked_add(packed)
            .filter(|data_at| *data_at < chain_at)
            .ok_or_else(wrong)?;

        let frame = source.part(frame_at, packed)?;
        let frame = perhaps_zlib(frame, plain).ok_or_else(wrong)?;
        let times = source.part(times_at, packed_times)?;
        let times = perhaps_zlib(times, plain_times).ok_or_else(wrong)?;
        let times = ticks(&times, count).ok_or_else(wrong)?;
        let data = source.part(data_at, NUMBERS.min(chain_at - data_at))?;
        let mut data = Bytes(&data);
        let in_chain = data.number().filter(|n| *n <= handles).ok_or_else(wrong)?;
        let origin = data_at + (NUMBERS.min(chain_at - data_at) - data.0.len() as u64);
        let packing = match data.byte().ok_or_else(wrong)? {
            b'4' => Packing::Lz4,
            b'F' => Packing::FastLz,
            _ => Packing::Zlib,
        };
        let chain = source.part(chain_at, chain_length)?;
        let (piece_of, starts) = chained(&chain, in_chain, is_signed).ok_or_else(wrong)?;
        let ends = starts.iter().skip(1).copied().chain([chain_at - origin]);
        let pieces = starts.iter().zip(ends).map(|(from, to)| {
            let length = to.checked_sub(*from).filter(|length| *length > 0)?;
            (to <= chain_at - origin).then_some((origin + from, length))
        });
        Ok(Self {
            pieces: pieces.collect::<Option<_>>().ok_or_else(wrong)?,
            start,
            end,
            frame,
            times,
            packing,
            piece_of,
        })
    }

    /// The number of a handle's piece; 0 where it does not change.
    pub(super) fn piece_of(&self, handle: u64) -> u32 {
        let index = usize::try_from(handle - 1).unwrap_or(usize::MAX);
        self.piece_of.get(index).copied().unwrap_or_default()
    }

    /// The changes in a piece, in the order of time and without repeated levels. More than [`MOST_CHANGES`] end with one more.
    pub(super) fn changes(
        &self,
        source: &mut Source<impl Read + Seek>,
        piece: u32,
    ) -> Result<Vec<Change>, Wrong> {
        let Some((at, length)) = (piece as usize).checked_sub(1).map(|n| self.pieces[n]) else {
            return Ok(Vec::new());
        };
        let wrong = || damaged("whole changes of a signal");
        let part = source.part(at, length)?;
        let mut rest = Bytes(&part);
        let unpacked;
        match rest.number().ok_or_else(wrong)? {
            0 => {}
            plain => {
                unpacked = self.packing.unpack(rest.0, plain).ok_or_else(wrong)?;
                rest = Bytes(&unpacked);
            }
        }
        let mut changes: Vec<Change> = Vec::new();
        let mut index = 0_u64;
        while !rest.0.is_empty() && changes.len() <= MOST_CHANGES {
            let coded = rest.number().ok_or_else(wrong)?;
            let (sign, steps) = match coded & 1 {
                0 => (b"01"[((coded >> 1) & 1) as usize], coded >> 2),
                _ => (b"xzhuwl--"[((coded >> 1) & 7) as usize], coded >> 4),
            };
            index = index.saturating_add(steps);
            if index >= self.times.len() as u64 {
                return Err(wrong());
            }
            let level = level(sign).flatten();
            if changes.last().is_none_or(|last| last.1 != level) {
                changes.push((index as u32, level));
            }
        }
        Ok(changes)
    }
}

/// Times from their distances; none where they are not `count` numbers.
fn ticks(distances: &[u8], count: u64) -> Option<Vec<u64>> {
    let mut rest = Bytes(distances);
    let (mut now, mut ticks) = (0_u64, Vec::new());
    while !rest.0.is_empty() {
        now = now.checked_add(rest.number()?)?;
        ticks.push(now);
    }
    (ticks.len() as u64 == count).then_some(ticks)
}

/// The number of each handle's piece, 0 for none, and the beginning of each piece. A handle whose changes are those of an earlier
/// one has its piece.
fn chained(chain: &[u8], handles: u64, is_signed: bool) -> Option<(Vec<u32>, Vec<u64>)> {
    let mut rest = Bytes(chain);
    let (mut piece_of, mut starts) = (Vec::new(), Vec::new());
    let (mut start, mut other) = (0_u64, None);
    while let Some(first) = rest.0.first() {
        let is_piece = first & 1 == 1;
        if is_signed && is_piece {
            match rest.signed()? >> 1 {
                0 => {}
                step @ 1.. => {
                    start = start.checked_add(step.unsigned_abs())?;
                    starts.push(start);
                    piece_of.push(starts.len() as u32);
                    continue;
                }
                step => other = Some(step.unsigned_abs() - 1),
            }
            piece_of.push(*piece_of.get(usize::try_from(other?).ok()?)?);
        } else {
            let number = rest.number()?;
            if number == 0 && !is_signed {
                let other = usize::try_from(rest.number()?.checked_sub(1)?).ok()?;
                piece_of.push(*piece_of.get(other)?);
            } else if is_piece {
                start = start.checked_add(number >> 1)?;
                starts.push(start);
                piece_of.push(starts.len() as u32);
            } else {
                let unchanged = usize::try_from((number >> 1).min(handles + 1)).ok()?;
                piece_of.resize(piece_of.len() + unchanged, 0);
            }
        }
        if piece_of.len() as u64 > handles {
            return None;
        }
    }
    (piece_of.len() as u64 == handles).then_some((piece_of, starts))
}
