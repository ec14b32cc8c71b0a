//! The heartbeat of a loop that waits, so that the guardian knows in a slow transfer that it is alive. Of several loops
//! only all together have one.

use std::os::fd::{AsRawFd, OwnedFd};
use std::sync::atomic::{AtomicU32, Ordering};
use std::sync::{Arc, Mutex, PoisonError};

use nix::sys::socket::{MsgFlags, send};

/// Loops that have made a turn since the last heartbeat. The next is due when all have that still go on: one that hangs
/// holds it back. Loops are bits of a mask.
#[derive(Debug)]
pub struct Round(Mutex<Marks>);

#[derive(Debug)]
struct Marks {
    going_on: u32,
    turned: u32,
}

impl Round {
    /// A round of so many loops, 32 at most, none of which has made a turn.
    pub fn new(loops: usize) -> Self {
        let going_on = (0..loops).fold(0, |all, number| all | Self::bit(number));
        Self(Mutex::new(Marks {
            going_on,
            turned: 0,
        }))
    }

    /// The bit of the loop of this number.
    pub const fn bit(number: usize) -> u32 {
        match number {
            0..32 => 1 << number,
            _ => 0,
        }
    }

    /// Marks loops that have made a turn, or wait for something with a limit. Returns whether a heartbeat is due: then
    /// the next round begins.
    pub fn turned(&self, loops: u32) -> bool {
        self.marks(|marks| {
            marks.turned |= loops;
            let is_due = marks.going_on != 0 && marks.going_on & !marks.turned == 0;
            if is_due {
                marks.turned = 0;
            }
            is_due
        })
    }

    /// Takes a loop out that has ended in order: no heartbeat waits for it any more.
    pub fn ended(&self, number: usize) {
        self.marks(|marks| marks.going_on &= !Self::bit(number));
    }

    fn marks<T>(&self, look: impl FnOnce(&mut Marks) -> T) -> T {
        // Marks are whole even where a thread panicked with the lock.
        look(&mut self.0.lock().unwrap_or_else(PoisonError::into_inner))
    }
}

/// Heartbeat of a loop while it waits for something with a limit.
#[derive(Clone, Debug)]
pub struct Pulse {
    link: Arc<OwnedFd>,
    beat: u8,
    /// Round and mask of the waiting loops, where there are several: only those that wait here count as alive.
    among: Option<(Arc<Round>, Arc<AtomicU32>)>,
}

impl Pulse {
    /// A heartbeat of one byte on this socket.
    pub const fn new(link: Arc<OwnedFd>, beat: u8) -> Self {
        Self {
            link,
            beat,
            among: None,
        }
    }

    /// A heartbeat among several loops, of which the `waiting` ones wait for the same thing.
    #[must_use]
    pub fn among(mut self, round: Arc<Round>, waiting: Arc<AtomicU32>) -> Self {
        self.among = Some((round, waiting));
        self
    }

    /// Sends one heartbeat; of several loops only once all of them are known to be alive.
    pub fn beat(&self) {
        if let Some((round, waiting)) = &self.among
            && !round.turned(waiting.load(Ordering::Relaxed))
        {
            return;
        }
        let flags = MsgFlags::MSG_DONTWAIT | MsgFlags::MSG_NOSIGNAL;
        // A guardian that is gone is noticed by its own client.
        let _ = send(self.link.as_raw_fd(), &[self.beat], flags);
    }
}

#[cfg(test)]
#[path = "pulse_tests.rs"]
mod tests;
