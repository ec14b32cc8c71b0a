//! Frames of an emulated skin, kept from the pass that finds the intensity levels for the pass that counts.
//!
//! Boards that get no commands send the same frames at the same times in both passes, so the second
//! need not emulate them again. Where that does not hold, a scene with faults or a loop that wants to talk
//! to its boards, the tape says so and the second pass emulates them.

use palpate_core::bus::{CanBus, Received};
use palpate_core::codec::can::CanFrame;
use palpate_core::units::Instant;
use palpate_emulators::sensor::rig::{Handle, HostError};
use palpate_emulators::time::Nanos;

use super::boards::{self, BusReport};
use super::skin_end::CanEnd;

/// Frames that a tape holds at most, 24 bytes each ([`Kept`]): three minutes of a hand of 240 taxels at 100 Hz. A
/// longer run is emulated twice.
const LIMIT: usize = 1 << 22;

/// A frame with the moment from which it can be received. The host's form is made from it: a kept frame takes a quarter
/// less memory, and fresh memory is the cost of a tape.
#[derive(Clone, Copy)]
struct Kept {
    at: Nanos,
    bus: u8,
    frame: CanFrame,
}

const _: () = assert!(size_of::<Kept>() == 24);

impl Kept {
    fn received(&self) -> Received {
        Received {
            at: Instant::from_micros(self.at.as_micros()),
            bus: self.bus,
            frame: self.frame,
        }
    }
}

/// A skin that is recorded while it is emulated, then played back.
pub struct Tape {
    skin: Handle,
    frames: Vec<Kept>,
    /// Index of the next frame to hand on.
    next: usize,
    records: bool,
    now: Nanos,
    /// `true` while the frames are all that the skin sent, and would be sent again.
    exact: bool,
}

impl Tape {
    /// An empty tape on a skin.
    pub const fn new(skin: Handle) -> Self {
        Self {
            skin,
            frames: Vec::new(),
            next: 0,
            records: true,
            now: Nanos::ZERO,
            exact: true,
        }
    }

    /// Plays the frames until `end` from the start.
    pub fn rewind(&mut self, end: Instant) {
        self.skin.advance(Nanos::from(end));
        (self.next, self.records, self.now) = (0, false, Nanos::ZERO);
    }

    /// Tells whether the tape has frames, and emulated boards would have sent the same.
    pub const fn is_exact(&self) -> bool {
        self.exact && !self.frames.is_empty()
    }

    /// Takes down the frames that the skin has sent.
    fn record(&mut self) {
        if self.frames.len() >= LIMIT && self.next == self.frames.len() {
            self.exact = false;
            self.next = 0;
            self.frames.clear();
        }
        let frames = &mut self.frames;
        self.skin.receive_all_at(&mut |at, received| {
            let Received { bus, frame, .. } = *received;
            frames.push(Kept { at, bus, frame });
        });
    }
}

impl CanEnd for Tape {
    fn advance_to(&mut self, now: Instant) {
        self.now = self.now.max(now.into());
        if self.records {
            self.skin.advance(self.now);
            self.record();
        }
    }

    fn buses(&self) -> Vec<BusReport> {
        self.skin.with(|buses| boards::buses(buses))
    }
}

impl CanBus for Tape {
    type Error = HostError;

    fn receive(&mut self) -> Result<Option<Received>, HostError> {
        let next = self.frames.get(self.next);
        let due = next.filter(|kept| kept.at <= self.now);
        self.next += usize::from(due.is_some());
        Ok(due.map(Kept::received))
    }

    fn receive_all(&mut self, take: &mut impl FnMut(&Received)) -> Result<(), HostError> {
        let waiting = self.frames.get(self.next..).unwrap_or_default();
        let due = waiting.iter().take_while(|kept| kept.at <= self.now);
        for kept in due {
            self.next += 1;
            take(&kept.received());
        }
        Ok(())
    }

    /// Sends nothing, and marks the tape as inexact: boards that got the frame would do something else than they did.
    fn transmit(&mut self, _bus: u8, _frame: &CanFrame) -> Result<(), HostError> {
        self.exact = false;
        Ok(())
    }
}

#[cfg(test)]
#[path = "tape_tests.rs"]
mod tests;
