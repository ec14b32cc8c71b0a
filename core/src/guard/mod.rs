//! The last stage before the driver: nothing reaches a wire that has not passed here.

use crate::units::{Board, Instant, Ticks};

/// What one channel shall do from now on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Setting {
    /// Tick at which the pulse starts in each period.
    pub on: u16,
    /// Tick at which it ends; equal to `on` for a channel that is off.
    pub off: u16,
}

/// An update of one board that the guard has passed. Only the guard can make one: its fields are
/// private and there is no other constructor, so a driver that takes a `Guarded` takes nothing else.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Guarded {
    at: Instant,
    board: Board,
    channels: [Option<Setting>; 16],
}

impl Guarded {
    /// When the update is to take effect.
    pub const fn at(&self) -> Instant {
        self.at
    }

    /// The board it is for.
    pub const fn board(&self) -> Board {
        self.board
    }

    /// The channels to change, by number; `None` leaves a channel as it is.
    pub const fn channels(&self) -> &[Option<Setting>; 16] {
        &self.channels
    }

    /// The widest pulse in the update.
    pub fn widest(&self) -> Ticks {
        let width = |s: &Setting| s.off.saturating_sub(s.on);
        Ticks::new(self.channels.iter().flatten().map(width).max().unwrap_or(0))
    }
}
