//! Amplifiers whose current is set: the most that may flow for a command, and the time at which it may change.
//!
//! A current rises only while its wire is off, and the driver reads it back before the pulse. Until that has succeeded the
//! larger of the commanded and the last confirmed current counts; where nothing is confirmed, the most there is.

use alloc::boxed::Box;
use alloc::vec;

use crate::schedule::{Reason, Stimulus};
use crate::units::{Board, Instant, Milliamps};

use super::{Guard, Plant, PlantError};

/// Parts per million of a whole.
const MILLION: u64 = 1_000_000;

/// Amplifiers whose current is set: full scale and the bounds of their error.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct CurrentControl {
    /// The current at the converter's full scale: the most that can be asked for.
    pub full_scale: Milliamps,
    /// Bound of the gain's error: the excess over the commanded current, parts per million.
    pub gain_ppm: u32,
    /// Bound of the offset: the excess that is added to the gain's error.
    pub offset: Milliamps,
}

impl CurrentControl {
    /// The most that flows for a command, rounded up.
    #[must_use]
    pub fn most(&self, commanded: Milliamps) -> Milliamps {
        let gain = (u64::from(commanded.0) * u64::from(self.gain_ppm)).div_ceil(MILLION);
        let sum = u64::from(commanded.0) + gain + u64::from(self.offset.0);
        // No plant bears so much: `check` refuses what is cut off here.
        Milliamps(u32::try_from(sum).unwrap_or(u32::MAX))
    }
}

/// State that a guard keeps of amplifiers whose current is set.
#[derive(Clone, Debug)]
pub(super) struct Settable {
    control: CurrentControl,
    /// Current that the driver has read back, by wire; `None` where that is unknown.
    confirmed: Box<[Option<Milliamps>]>,
}

impl Settable {
    /// The current that the driver last read back from a wire's amplifier.
    fn confirmed(&self, wire: usize) -> Option<Milliamps> {
        self.confirmed.get(wire).copied().flatten()
    }

    /// The most that an amplifier may be set to: the confirmed current, or full scale where none is confirmed.
    fn set(&self, confirmed: Option<Milliamps>) -> Milliamps {
        confirmed.unwrap_or(self.control.full_scale)
    }
}

impl Guard {
    /// Puts the guard before amplifiers whose current is set. The plant's current becomes the most that they can
    /// give, if that is more: the rows of the supply and all budgets count with it.
    ///
    /// # Errors
    /// [`PlantError`] when no wire can have such a current.
    pub fn with_current(mut self, control: CurrentControl) -> Result<Self, PlantError> {
        if control.full_scale == Milliamps(0) {
            return Err(PlantError::OutOfRange);
        }
        self.plant.peak = self.plant.peak.max(control.most(control.full_scale));
        self.plant.check()?;
        self.settable = Some(Box::new(Settable {
            control,
            confirmed: vec![None; self.wires.len()].into(),
        }));
        Ok(self)
    }

    /// The amplifiers' bounds, if their current is set.
    pub fn current_control(&self) -> Option<&CurrentControl> {
        self.settable.as_ref().map(|settable| &settable.control)
    }

    /// Confirms every current that a driver has put on a board's outputs: it was set and has read back.
    pub(super) fn confirm_currents(
        &mut self,
        on: Board,
        current: impl Fn(u8) -> Option<Milliamps>,
    ) {
        let Some(settable) = &mut self.settable else {
            return;
        };
        for (wire, confirmed) in self.wires.iter().zip(&mut settable.confirmed) {
            let (board, channel) = wire.place;
            if board == on
                && let Some(current) = current(channel)
            {
                *confirmed = Some(current);
            }
        }
    }

    /// Forgets every current that was confirmed.
    pub(super) fn forget_currents(&mut self) {
        if let Some(settable) = &mut self.settable {
            settable.confirmed.fill(None);
        }
    }

    /// The current that a stimulus is driven with, and the reason if that is less than it asks for. `None` where the
    /// amplifiers have a current of their own.
    pub(super) fn commanded(
        &self,
        wire: usize,
        at: Instant,
        s: &Stimulus,
    ) -> Option<(Milliamps, Option<Reason>)> {
        let settable = self.settable.as_ref()?;
        // A pulse of the stimulus before may still come, and it was booked with the current that is set now.
        let end = self.wires.get(wire)?.burst.map(|burst| burst.end());
        let is_off = end.is_none_or(|end| at >= end + self.plant.surplus());
        let most = match is_off {
            true => settable.control.full_scale,
            false => settable.set(settable.confirmed(wire)),
        };
        let reason = (s.peak > most).then_some(Reason::Current);
        Some((s.peak.min(most), reason))
    }

    /// The plant by which a stimulus of this current counts: the larger of it and of the current that may be set.
    pub(super) fn counting(&self, wire: usize, commanded: Option<Milliamps>) -> Plant {
        let confirmed = self.settable.as_ref().and_then(|s| s.confirmed(wire));
        self.counting_after(confirmed, commanded)
    }

    /// The plant by which a stimulus of this current counts on any wire whose amplifier had `confirmed` before.
    pub(super) fn counting_after(
        &self,
        confirmed: Option<Milliamps>,
        commanded: Option<Milliamps>,
    ) -> Plant {
        match (&self.settable, commanded) {
            (Some(settable), Some(commanded)) => Plant {
                peak: settable
                    .control
                    .most(commanded.max(settable.set(confirmed))),
                ..self.plant
            },
            _ => self.plant,
        }
    }

    /// The plant by which the present current of a wire counts.
    pub(super) fn flowing(&self, wire: usize) -> Plant {
        self.counting(wire, Some(Milliamps(0)))
    }
}

#[cfg(test)]
#[path = "current_tests.rs"]
mod tests;
