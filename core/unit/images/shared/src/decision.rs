//! A guard questioned from afar: how an image's guard is compared with a host's, decision by decision. Both ends run
//! [`answer`], each on its own guard and its own processor.

use palpate_core::guard::{Cause, Guard};
use palpate_core::schedule::{Entry, Stimulus};
use palpate_core::units::{Board, Duration, Instant, Ticks};

/// Most bytes of a question.
pub const QUESTION: usize = 10 + 8 * MOST;
/// Most bytes of an answer.
pub const ANSWER: usize = 9 + 16 * 12 + 14 * MOST;
/// Most stimuli of a question.
const MOST: usize = 16;

/// Request to a guard at a time.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Question<'a> {
    /// A reading was received.
    Hear,
    /// The watchdog's look.
    Watch,
    /// Stimuli of a board that are over end.
    Expire(Board),
    /// Change of a board's stimuli, at most sixteen: wire, width, length.
    Change(Board, &'a [(u16, Ticks, Duration)]),
    /// Switch everything off, and latch.
    Stop,
    /// The guard's reset after a stop.
    Reset,
}

impl Question<'_> {
    /// Writes the question; returns its bytes.
    pub fn write<'o>(&self, at: Instant, out: &'o mut [u8; QUESTION]) -> &'o [u8] {
        let none: &[(u16, Ticks, Duration)] = &[];
        let (number, board, stimuli) = match self {
            Self::Hear => (0, 0, none),
            Self::Watch => (1, 0, none),
            Self::Expire(board) => (2, board.0, none),
            Self::Change(board, stimuli) => (3, board.0, *stimuli),
            Self::Stop => (4, 0, none),
            Self::Reset => (5, 0, none),
        };
        out[..8].copy_from_slice(&at.as_micros().to_le_bytes());
        (out[8], out[9]) = (number, board);
        let mut length = 10;
        for (wire, width, span) in stimuli.iter().take(MOST) {
            let us = u32::try_from(span.as_micros()).unwrap_or(u32::MAX);
            out[length..length + 2].copy_from_slice(&wire.to_le_bytes());
            out[length + 2..length + 4].copy_from_slice(&width.get().to_le_bytes());
            out[length + 4..length + 8].copy_from_slice(&us.to_le_bytes());
            length += 8;
        }
        &out[..length]
    }
}

/// Bytes one after the other; what does not fit is left out.
struct Out<'a>(&'a mut [u8], usize);

impl Out<'_> {
    fn put(&mut self, bytes: &[u8]) {
        let end = self.1 + bytes.len();
        if let Some(room) = self.0.get_mut(self.1..end) {
            room.copy_from_slice(bytes);
            self.1 = end;
        }
    }

    fn entry(&mut self, entry: &Entry) {
        self.put(&[entry.channel.0, entry.reason.map_or(u8::MAX, |r| r as u8)]);
        self.put(&entry.on.to_le_bytes());
        self.put(&entry.off.to_le_bytes());
        self.put(&entry.until.as_micros().to_le_bytes());
    }
}

fn number<const N: usize>(bytes: &[u8], at: usize) -> [u8; N] {
    let found = bytes.get(at..at + N).and_then(|b| b.try_into().ok());
    found.unwrap_or([0; N])
}

/// Puts a question to a guard. Returns the length of the answer in `out`, and what `clock` counted during the guard's own
/// work alone. A question that is none is a look of the watchdog.
pub fn answer(
    guard: &mut Guard,
    question: &[u8],
    clock: impl Fn() -> u32,
    out: &mut [u8; ANSWER],
) -> (usize, u32) {
    let at = Instant::from_micros(u64::from_le_bytes(number(question, 0)));
    let [kind, board] = number(question, 8);
    let board = Board(board);
    let mut stimuli = [Stimulus {
        wire: 0,
        width: Ticks::ZERO,
        peak: guard.plant().peak,
        at,
        until: at,
    }; MOST];
    let mut count = 0;
    let asked = question.get(10..).unwrap_or_default().chunks_exact(8);
    for (slot, asked) in stimuli.iter_mut().zip(asked) {
        slot.wire = u16::from_le_bytes(number(asked, 0));
        slot.width = Ticks::new(u16::from_le_bytes(number(asked, 2)));
        let us = u32::from_le_bytes(number(asked, 4));
        slot.until = at + Duration::from_micros(us.into());
        count += 1;
    }
    let mut entries = [None; MOST];
    let mut judged = 0;
    let began = clock();
    let update = match kind {
        0 => {
            guard.hear(at);
            None
        }
        2 => Some(guard.expire(at, board)),
        3 => Some(guard.change(at, board, &stimuli[..count], |entry| {
            if let Some(slot) = entries.get_mut(judged) {
                *slot = Some(entry);
                judged += 1;
            }
        })),
        4 => {
            guard.latch(Cause::End);
            guard.all_off(at);
            None
        }
        5 => {
            // Refused while its cause lasts: the answer says whether it is latched.
            let _ = guard.reset(at);
            None
        }
        _ => {
            if let Some(cause) = guard.watch(at) {
                guard.latch(cause);
                guard.all_off(at);
            }
            None
        }
    };
    // There is no board that could refuse it.
    update.iter().for_each(|update| guard.confirm(update, at));
    let took = clock().wrapping_sub(began);
    let mut out = Out(out, 0);
    out.put(&[guard.latched().map_or(u8::MAX, |c| c as u8)]);
    let next = guard.next_expiry().map_or(u64::MAX, Instant::as_micros);
    out.put(&next.to_le_bytes());
    if let Some(update) = &update {
        for (setting, end) in update.channels().iter().zip(update.ends()) {
            let (on, off) = setting.map_or((u16::MAX, u16::MAX), |s| (s.on, s.off));
            out.put(&on.to_le_bytes());
            out.put(&off.to_le_bytes());
            out.put(&end.as_micros().to_le_bytes());
        }
    }
    entries.iter().flatten().for_each(|entry| out.entry(entry));
    (out.1, took)
}
