//! Overruns: a channel that was told to go off counts as on until its driver says that it is off. The guard books the
//! current that flows meanwhile, and a wire that is on for too long is an overrun.

use core::cmp::Ordering;

use crate::units::{Duration, Instant};

use super::{Guard, Guarded, Running};

/// Wires that were on for longer than [`Guard::longest`]. They passed their limits: the heat has flowed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Overrun {
    /// The wire that was on for longest.
    pub wire: u16,
    /// Time from the beginning of its burst until it was known to be off, or until now if it still is on.
    pub on: Duration,
    /// The most electrical energy that was booked for such a burst, nJ.
    pub energy_nj: u64,
}

/// A channel that was told to go off and is not known to be.
#[derive(Clone, Copy, Debug)]
pub(super) struct Ending {
    /// The pulse that it was driven with; its end is the time up to which it is booked.
    was: Running,
    /// The beginning of its burst.
    since: Instant,
}

impl Guard {
    /// The longest that a wire may be on, from the beginning of its burst until it is known to be off: a burst and
    /// the [`Self::surplus`] of a channel beyond its stimulus. Within that time nothing distinguishes a burst that
    /// kept its limit from one that passed it.
    pub fn longest(&self) -> Duration {
        self.limits.burst + self.plant.surplus()
    }

    /// The overrun, if any wire was on for too long since the guard was made.
    pub const fn overrun(&self) -> Option<Overrun> {
        self.overrun
    }

    /// Returns true if an overrun was found that no latch has followed: the outputs are to be switched off for
    /// [`Cause::Overrun`](super::Cause::Overrun).
    pub const fn overran(&self) -> bool {
        self.overran
    }

    /// Confirms that a driver has put an update on the outputs, where it is known to stand since `at`: every current
    /// in it was set and has read back, and the channels that it switched off are off.
    pub fn confirm(&mut self, update: &Guarded, at: Instant) {
        for index in 0..self.wires.len() {
            let (board, channel) = self.wires[index].place;
            let changed = update.channels.get(usize::from(channel));
            if board == update.board && changed.is_some_and(Option::is_some) {
                self.end(index, at);
            }
        }
        self.confirm_currents(update.board, |channel| update.current(channel));
    }

    /// Tells everything to go off at `at`; it counts as on until [`Self::all_off`]. No current is confirmed any more.
    pub fn ask_off(&mut self, at: Instant) {
        for index in 0..self.wires.len() {
            if let Some(was) = self.wires[index].now.take() {
                self.told_off(index, was, at);
            }
        }
        self.forget_currents();
    }

    /// Takes everything as off since `at`: by an all-off of the driver, or because its outputs are cut.
    pub fn all_off(&mut self, at: Instant) {
        self.ask_off(at);
        for index in 0..self.wires.len() {
            self.end(index, at);
        }
    }

    /// Books every channel that is not known to be off as on until `at`; it may still be on.
    pub fn still_on(&mut self, at: Instant) {
        for index in 0..self.wires.len() {
            if let Some(mut ending) = self.wires[index].ending {
                self.flowed(index, &ending, at);
                ending.was.until = ending.was.until.max(at - self.plant.switching());
                self.wires[index].ending = Some(ending);
            }
        }
    }

    /// Tells a channel to go off at `at`.
    pub(super) fn told_off(&mut self, index: usize, was: Running, at: Instant) {
        self.book_late(index, &was, at);
        if self.looks_on {
            return; // emulated registers take it at once
        }
        let wire = &mut self.wires[index];
        let begun = wire.burst.map_or(was.since, |burst| burst.start);
        let until = was.until.max(at);
        let mut ending = Ending {
            was: Running { until, ..was },
            since: begun.min(was.since),
        };
        if let Some(earlier) = wire.ending {
            // A channel that never took the setting before may have kept the wider of both ever since.
            let setting = match was.setting.width().cmp(&earlier.was.setting.width()) {
                Ordering::Greater => was.setting,
                _ => earlier.was.setting,
            };
            ending.was = Running {
                setting,
                ..earlier.was
            };
            ending.since = ending.since.min(earlier.since);
        }
        wire.ending = Some(ending);
    }

    /// Takes a channel that was told to go off as off since `at`.
    fn end(&mut self, index: usize, at: Instant) {
        if let Some(ending) = self.wires[index].ending.take() {
            self.flowed(index, &ending, at);
        }
    }

    /// Books the energy of a channel that was told to go off, until `at`; the bus's own time is booked already.
    fn flowed(&mut self, index: usize, ending: &Ending, at: Instant) {
        self.book_late(index, &ending.was, at - self.plant.switching());
        self.weigh(index, ending.since, at);
    }

    /// Looks at the wires that are not known to be off, for the watchdog. Returns true if one has been on for too
    /// long.
    pub(super) fn is_overdue(&mut self, now: Instant) -> bool {
        let mut overdue = false;
        for index in 0..self.wires.len() {
            if let Some(ending) = self.wires[index].ending {
                overdue |= self.weigh(index, ending.since, now);
            }
        }
        overdue
    }

    /// Records an overrun if a wire was on between two times for too long, and returns true if so.
    fn weigh(&mut self, index: usize, since: Instant, until: Instant) -> bool {
        let on = until.since(since);
        if on <= self.longest() {
            return false;
        }
        self.overran = true;
        let spent_nj = self.wires[index].burst.map_or(0, |burst| burst.spent_nj);
        let worst = self.overrun.get_or_insert(Overrun {
            wire: index as u16, // a display has at most 256 wires
            on,
            energy_nj: spent_nj,
        });
        worst.energy_nj = worst.energy_nj.max(spent_nj);
        if on > worst.on {
            (worst.wire, worst.on) = (index as u16, on);
        }
        true
    }
}

#[cfg(test)]
#[path = "overrun_tests.rs"]
mod tests;
