//! What an emulated skin sent, kept from the pass that finds the intensity levels for the pass that counts.
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

/// Frames that a tape holds at most, 24 bytes each ([`Kept`]): three minutes of a hand of 240 taxels at 100 Hz. What is
/// longer is emulated twice.
const LIMIT: usize = 1 << 22;

/// A frame with the moment from which it can be received. What a host receives is made of it: as kept, a frame takes a
/// quarter less memory, and fresh memory is what a tape costs.
#[derive(Clone, Copy)]
struct Kept {
    at: Nanos,
    bus: u8,
    frame: CanFrame,
}

const _: () = assert!(size_of::<Kept>() == 24);

/// A skin that is recorded while it is emulated, then played back.
pub struct Tape {
    skin: Handle,
    frames: Vec<Kept>,
    /// The next frame to play; `None` while recording.
    next: Option<usize>,
    now: Nanos,
    /// Whether the frames are all that the skin sent, and would be sent again.
    exact: bool,
}

impl Tape {
    /// An empty tape on a skin.
    pub const fn new(skin: Handle) -> Self {
        Self {
            skin,
            frames: Vec::new(),
            next: None,
            now: Nanos::ZERO,
            exact: true,
        }
    }

    /// Plays from the start what came until `end`.
    pub fn rewind(&mut self, end: Instant) {
        self.skin.advance(Nanos::from(end));
        (self.next, self.now) = (Some(0), Nanos::ZERO);
    }

    /// Whether something was recorded, and what was played is what emulated boards would have sent.
    pub const fn is_exact(&self) -> bool {
        self.exact && !self.frames.is_empty()
    }
}

impl CanEnd for Tape {
    fn advance_to(&mut self, now: Instant) {
        self.now = self.now.max(now.into());
        if self.next.is_none() {
            self.skin.advance(self.now);
        }
    }

    fn buses(&self) -> Vec<BusReport> {
        self.skin.with(|buses| boards::buses(buses))
    }
}

impl CanBus for Tape {
    type Error = HostError;

    fn receive(&mut self) -> Result<Option<Received>, HostError> {
        if let Some(next) = &mut self.next {
            let due = self.frames.get(*next).filter(|kept| kept.at <= self.now);
            *next += usize::from(due.is_some());
            return Ok(due.map(|kept| Received {
                at: Instant::from_micros(kept.at.as_micros()),
                bus: kept.bus,
                frame: kept.frame,
            }));
        }
        let Some((at, received)) = self.skin.receive_at() else {
            return Ok(None);
        };
        if self.frames.len() < LIMIT {
            let Received { bus, frame, .. } = received;
            self.frames.push(Kept { at, bus, frame });
        } else {
            self.exact = false;
        }
        Ok(Some(received))
    }

    /// Nothing is sent: from here on boards would do something else than they did.
    fn transmit(&mut self, _bus: u8, _frame: &CanFrame) -> Result<(), HostError> {
        self.exact = false;
        Ok(())
    }
}

#[cfg(test)]
#[path = "tape_tests.rs"]
mod tests;
