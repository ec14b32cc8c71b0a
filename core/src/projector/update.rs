//! The kinds of update: those that a guard of wires or of motors has passed, and one that it only observed.

use crate::guard::{Guard, Guarded, GuardedVibration, Observed};
use crate::schedule::{Entry, Stimulus};
use crate::units::{Board, Instant};

/// An update as the loop puts it on the outputs: [`Guarded`] for wires, [`GuardedVibration`] for motors, or [`Observed`]
/// where the guard only looks on.
pub trait Update: Sized {
    /// `true` where a stop of the guard switches off.
    const STOPS: bool;

    /// Returns what the stimuli of one board change, if anything.
    fn begin(
        guard: &mut Guard,
        at: Instant,
        board: Board,
        stimuli: &[Stimulus],
        ledger: impl FnMut(Entry),
    ) -> Option<Self>;

    /// Returns what has ended on one board, if anything.
    fn end(guard: &mut Guard, at: Instant, board: Board) -> Option<Self>;

    /// Tells the guard that this stands on the outputs since `at`.
    fn confirm(&self, guard: &mut Guard, at: Instant);
}

impl Update for Guarded {
    const STOPS: bool = true;

    fn begin(
        guard: &mut Guard,
        at: Instant,
        board: Board,
        stimuli: &[Stimulus],
        ledger: impl FnMut(Entry),
    ) -> Option<Self> {
        Some(guard.admit(at, board, stimuli, ledger)).filter(Self::changes)
    }

    fn end(guard: &mut Guard, at: Instant, board: Board) -> Option<Self> {
        Some(guard.expire(at, board)).filter(Self::changes)
    }

    fn confirm(&self, guard: &mut Guard, at: Instant) {
        guard.confirm(self, at);
    }
}

impl Update for GuardedVibration {
    const STOPS: bool = true;

    fn begin(
        guard: &mut Guard,
        at: Instant,
        board: Board,
        stimuli: &[Stimulus],
        ledger: impl FnMut(Entry),
    ) -> Option<Self> {
        guard
            .admit_vibration(at, board, stimuli, ledger)
            .filter(Self::changes)
    }

    fn end(guard: &mut Guard, at: Instant, board: Board) -> Option<Self> {
        guard.expire_vibration(at, board).filter(Self::changes)
    }

    fn confirm(&self, guard: &mut Guard, at: Instant) {
        guard.confirm_vibration(self, at);
    }
}

impl Update for Observed {
    const STOPS: bool = false;

    fn begin(
        guard: &mut Guard,
        at: Instant,
        board: Board,
        stimuli: &[Stimulus],
        ledger: impl FnMut(Entry),
    ) -> Option<Self> {
        guard.observe(at, board, stimuli, ledger)
    }

    fn end(guard: &mut Guard, at: Instant, board: Board) -> Option<Self> {
        guard.observe_expiry(at, board)
    }

    fn confirm(&self, guard: &mut Guard, _: Instant) {
        guard.confirm_observed(self);
    }
}

#[cfg(test)]
#[path = "update_tests.rs"]
mod tests;
