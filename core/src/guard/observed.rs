//! A run that the guard only observes: it books what is driven, notes the changes that it would have made, and makes
//! none.
//!
//! Only emulated benches have such a run. Its updates have a type of their own that no driver takes.

use crate::schedule::{Entry, Stimulus};
use crate::units::{Board, Instant, Milliamps};

use super::{Guard, Guarded, Setting};

/// Channel settings of one board that the guard observed and did not judge. No driver takes them:
///
/// ```compile_fail,E0308
/// # use palpate_core::{driver::Actuators, guard::Observed};
/// fn drive<A: Actuators>(driver: &mut A, observed: &Observed) {
///     let _ = driver.apply(observed);
/// }
/// ```
///
/// Nothing turns them into an update that a driver takes:
///
/// ```compile_fail,E0277
/// # use palpate_core::guard::{Guarded, Observed};
/// fn forge(observed: Observed) -> Guarded {
///     observed.into()
/// }
/// ```
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Observed {
    board: Board,
    channels: [Option<Setting>; 16],
    currents: [Option<Milliamps>; 16],
}

impl Observed {
    /// The board it is for.
    pub const fn board(&self) -> Board {
        self.board
    }

    /// Settings of every channel that carries a wire, by number, unchanged ones too.
    pub const fn channels(&self) -> &[Option<Setting>; 16] {
        &self.channels
    }

    /// Current to which the amplifier of each channel that goes on shall be set before, where its current is set.
    pub const fn currents(&self) -> &[Option<Milliamps>; 16] {
        &self.currents
    }
}

impl Guard {
    /// Books stimuli like [`Self::admit`], but leaves each unchanged. The entry names the reason for which `admit`
    /// would have changed or refused it. Heat, dose and energy are booked as they flow. Returns `None` where no
    /// channel changes.
    pub fn observe(
        &mut self,
        at: Instant,
        board: Board,
        stimuli: &[Stimulus],
        ledger: impl FnMut(Entry),
    ) -> Option<Observed> {
        self.looks_on = true;
        let update = self.release(at, board);
        let update = self.pass(update, stimuli, Self::note, ledger);
        update.changes().then(|| self.observed(&update))
    }

    /// Ends the stimuli of one board that are over at `at`. `None` where none is.
    #[cfg(target_has_atomic = "ptr")]
    pub(crate) fn observe_expiry(&mut self, at: Instant, board: Board) -> Option<Observed> {
        let update = self.expire(at, board);
        update.changes().then(|| self.observed(&update))
    }

    /// Confirms an observed update: emulated registers hold it, and every current in it was set.
    #[cfg(target_has_atomic = "ptr")]
    pub(crate) fn confirm_observed(&mut self, update: &Observed) {
        let current = |channel: u8| {
            let slot = update.currents.get(usize::from(channel));
            slot.copied().flatten()
        };
        self.confirm_currents(update.board, current);
    }

    /// The present settings of the wires of an update's board, and the currents of those that it switches on.
    fn observed(&self, update: &Guarded) -> Observed {
        let board = update.board();
        let mut currents = [None; 16];
        if self.settable.is_some() {
            for (channel, current) in (0..).zip(&mut currents) {
                *current = update.current(channel);
            }
        }
        let mut channels = [None; 16];
        for wire in self.wires.iter().filter(|w| w.place.0 == board) {
            if let Some(slot) = channels.get_mut(usize::from(wire.place.1)) {
                *slot = Some(
                    wire.now
                        .map_or(Setting { on: 0, off: 0 }, |now| now.setting),
                );
            }
        }
        Observed {
            board,
            channels,
            currents,
        }
    }
}

#[cfg(test)]
#[path = "observed_tests.rs"]
mod tests;
