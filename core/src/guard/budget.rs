//! Budgets that a renderer may plan with: the part of a stimulus that each limit leaves, before the guard gets it.
//!
//! Reading changes nothing, and [`Guard::admit`] stays the last word. The figures are the ones by which it decides,
//! at the worst corner of its range, for what is booked so far.

use crate::schedule::Reason;
use crate::units::{Duration, Instant, Ticks};

use super::Guard;
use super::admission::faded;
use super::decays::{Decays, RATES};
use super::kernel::Kernel;
use super::power::Bucket;

/// The second that [`Guard::second_uw`] looks ahead.
const SECOND: Duration = Duration::from_millis(1000);

/// The most of a stimulus that the limits leave one wire between two times. A stimulus within all of it passes
/// unchanged.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct WireBudget {
    /// The widest pulse.
    pub widest: Ticks,
    /// The latest end: that of the stimulus, or the burst's before it.
    pub until: Instant,
    /// True if the supply bears such a pulse beside the boards that are on.
    pub supply: bool,
    /// Electrical energy, nJ, that each row leaves until that end, as [`Guard::energy_nj`] counts it.
    /// Rows that fill again keep back what the guard keeps back. The dose is `u64::MAX` where it limits less than
    /// the peak.
    pub energy_nj: [(Reason, u64); 7],
}

impl WireBudget {
    /// The energy, nJ, that all rows leave, and the first row that leaves no more.
    pub fn least(&self) -> (Reason, u64) {
        let [first, others @ ..] = self.energy_nj;
        let less = |least: (Reason, u64), row: (Reason, u64)| {
            if row.1 < least.1 { row } else { least }
        };
        others.into_iter().fold(first, less)
    }
}

/// Nanojoules, rounded down; nothing left is zero.
fn nanojoules(joules: f64) -> u64 {
    (joules * 1e9) as u64
}

impl Guard {
    /// Returns what one wire may be driven with between `at` and `until` if nothing else is driven at that onset.
    /// Each stimulus of an onset takes from the fingertip's row before the next one. Wires of the board that are on
    /// end with the onset.
    ///
    /// Returns `None` for an unknown wire, for a time that ends before it begins, for a latched guard, and for a
    /// guard without thermal rows: a renderer plans with a whole guard.
    pub fn budget(&self, wire: usize, at: Instant, until: Instant) -> Option<WireBudget> {
        let state = self.wires.get(wire)?;
        let burst = self.burst_at(wire, at);
        let until = until.min(self.latest(&burst));
        if self.latched().is_some() || until <= at {
            return None;
        }
        let off = until + self.plant.surplus();
        let [peak, dose, deep, mean] =
            self.rooms(wire, at, off)?
                .map(|(j, row)| match j.is_finite() {
                    true => (row, faded(nanojoules(j))),
                    false => (row, u64::MAX),
                });
        let burst_nj = self.limits.burst_energy_nj.saturating_sub(burst.spent_nj);
        let left = |pj: u64| faded(pj / 1000);
        Some(WireBudget {
            widest: self.widest(),
            until,
            supply: self.supply_is_free(wire),
            energy_nj: [
                (Reason::Burst, burst_nj),
                peak,
                dose,
                deep,
                mean,
                (Reason::WirePower, left(state.power.left_pj_at(at))),
                (Reason::FingertipPower, self.fingertip_nj(at)),
            ],
        })
    }

    /// Energy, J, that each row of heat leaves a wire that is on between two times.
    pub(super) fn rooms(
        &self,
        wire: usize,
        at: Instant,
        off: Instant,
    ) -> Option<[(f64, Reason); 4]> {
        let heat = self.heat.as_ref()?;
        let tissue = heat.tissues.get(wire)?;
        let booking = tissue.booking(at, off, self.plant.latency());
        Some(tissue.each_room(&heat.budget, booking))
    }

    /// Electrical energy, nJ, that the row of the fingertip's power leaves for a stimulus at `at` on any wire.
    pub(crate) fn fingertip_nj(&self, at: Instant) -> u64 {
        faded(self.fingertip.left_pj_at(at) / 1000)
    }

    /// Mean power, uW, that each row leaves one wire for the second from `at` on. A row of power gives the most that
    /// the guard passes in it. A row of heat gives what may flow evenly, so that the limit is met at the second's
    /// end. `None` for an unknown wire, and without thermal rows.
    pub fn second_uw(&self, wire: usize, at: Instant) -> Option<[(Reason, u64); 6]> {
        let state = self.wires.get(wire)?;
        let rooms = self.rooms(wire, at, at + SECOND)?;
        let [peak, dose, deep, mean] = rooms.map(|(j, row)| match j.is_finite() {
            true => (row, nanojoules(j) / 1000),
            false => (row, u64::MAX),
        });
        let most = |bucket: &Bucket| bucket.most_nj(at, SECOND);
        let (power, tip) = (most(&state.power), most(&self.fingertip));
        Some([
            peak,
            dose,
            deep,
            mean,
            (Reason::WirePower, power / 1000),
            (Reason::FingertipPower, tip / 1000),
        ])
    }

    /// Mean power, uW, that may flow evenly into one wire for a whole session from rest: the rows of power and of
    /// heat bear it at the session's end. The dose is left out.
    pub(crate) fn sustained_uw(&self, session: Duration) -> u64 {
        let seconds = session.as_secs_f64();
        let per_watt = |row: &Decays| -> f64 {
            let each = row.iter().zip(&RATES);
            each.map(|(c, r)| c / r * (1.0 - libm::exp(-r * seconds)))
                .sum()
        };
        let heat = self.heat.as_ref().map_or(f64::INFINITY, |heat| {
            let Kernel { shallow, deep, .. } = &heat.budget.kernel;
            heat.budget.even_w(per_watt(shallow), per_watt(deep))
        });
        let power = self.wires.iter().map(|w| w.power.rate_uw());
        let power = power.fold(self.fingertip.rate_uw(), u64::min);
        power.min((heat * 1e6) as u64)
    }

    /// Electrical energy, nJ, booked for a stimulus of this width and length: from above over all oscillators.
    pub fn energy_nj(&self, width: Ticks, length: Duration) -> u64 {
        self.plant.energy_nj(width.get(), length)
    }
}

#[cfg(test)]
#[path = "budget_tests.rs"]
mod tests;
