//! What a wearer had before a run began: bursts of earlier runs, whose heat and dose a new guard takes over.
//!
//! A session of many short runs would else begin each of them with cold skin and no dose.

use alloc::vec::Vec;

use super::{Booked, Guard};
use crate::units::Instant;

/// Bursts of earlier runs, in a time of their own.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Earlier {
    /// Wire and burst, in order of time.
    pub bursts: Vec<(u16, Booked)>,
    /// When the new run begins; not before the last of them is over.
    pub until: Instant,
}

impl Earlier {
    /// Bursts of a run that began at a time, in its own time, added to those before.
    pub fn extend(&mut self, began: Instant, bursts: impl IntoIterator<Item = (u16, Booked)>) {
        let shift = began.since(Instant::ZERO);
        let shifted = bursts.into_iter().map(|(wire, burst)| {
            let booked = Booked {
                on: burst.on + shift,
                off: burst.off + shift,
                ..burst
            };
            (wire, booked)
        });
        self.bursts.extend(shifted);
        self.bursts.sort_by_key(|(_, burst)| burst.on);
        let ends = self.bursts.iter().map(|(_, burst)| burst.off);
        self.until = ends.fold(self.until, Instant::max);
    }
}

impl Guard {
    /// Takes over what the wearer had before t = 0. For a guard that has passed nothing yet. Wires that it does not have are
    /// left out.
    pub fn remember(&mut self, earlier: &Earlier) {
        if earlier.bursts.is_empty() {
            return;
        }
        let latency = self.plant.latency();
        for (wire, burst) in &earlier.bursts {
            let index = usize::from(*wire);
            let Some(state) = self.wires.get_mut(index) else {
                continue;
            };
            for bucket in [&mut state.power, &mut self.fingertip] {
                bucket.left_nj(burst.on);
                bucket.spend(burst.energy_nj);
            }
            if let Some(heat) = &mut self.heat {
                let tissue = &mut heat.tissues[index];
                let booking = tissue.booking(burst.on, burst.off, latency);
                let joules = burst.energy_nj as f64 * 1e-9;
                let predicted = tissue.heat(&mut heat.budget, booking, joules);
                heat.predicted.raise(&predicted);
            }
        }
        for wire in &mut self.wires {
            wire.power.rebase(earlier.until);
        }
        self.fingertip.rebase(earlier.until);
        if let Some(heat) = &mut self.heat {
            for tissue in &mut heat.tissues {
                tissue.begun = earlier.until.since(Instant::ZERO);
            }
        }
    }
}

#[cfg(test)]
#[path = "earlier_tests.rs"]
mod tests;
