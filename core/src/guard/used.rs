//! The used share of each limit: a page, a terminal and a summary show it while the guard works.
//!
//! Reading changes nothing and allocates nothing. The figures are the guard's own upper bounds: they count what is
//! booked, which is at least what flowed.

use crate::units::Instant;

use super::Guard;

/// The used share of each limit, the worst of all wires: 0 is rest, 1 the limit. A guard without thermal rows has 0
/// in the rows of heat.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Used {
    /// Width of the pulses that are on.
    pub pulse: f64,
    /// Length of the burst that goes on; none goes on once its gap is over.
    pub burst: f64,
    /// Energy of that burst.
    pub burst_energy: f64,
    /// Energy that both windows of a wire's mean power let it spend at once.
    pub wire_power: f64,
    /// Energy that both windows of the fingertip's mean power let it spend at once.
    pub fingertip_power: f64,
    /// Current of all wires that are on.
    pub supply: f64,
    /// Skin 0.1 mm deep as a mean over the last ten seconds, from rest.
    pub skin_mean: f64,
    /// Skin 0.1 mm deep, from rest.
    pub skin_peak: f64,
    /// Skin 0.4 mm deep, from rest.
    pub skin_deep: f64,
    /// Henriques' Omega of the session.
    pub omega: f64,
    /// Cumulative equivalent time at 43 C of the session.
    pub cem43: f64,
}

impl Used {
    /// Every row in the order of the guard's table: its key in a file of limits, in short, and its share.
    pub const fn rows(&self) -> [(&'static str, f64); 11] {
        [
            ("pulse", self.pulse),
            ("burst", self.burst),
            ("burst_energy", self.burst_energy),
            ("wire_power", self.wire_power),
            ("fingertip_power", self.fingertip_power),
            ("supply", self.supply),
            ("skin_mean", self.skin_mean),
            ("skin_peak", self.skin_peak),
            ("skin_deep", self.skin_deep),
            ("omega", self.omega),
            ("cem43", self.cem43),
        ]
    }
}

/// A part of a limit. A limit that allows nothing is unused at zero, and used up by anything.
fn share(part: u64, limit: u64) -> f64 {
    match limit {
        0 => f64::from(u8::from(part > 0)),
        limit => part as f64 / limit as f64,
    }
}

impl Guard {
    /// The used share of each limit at `now`. Heat counts from its onset: a burst that goes on is in it whole.
    pub fn used(&self, now: Instant) -> Used {
        let mut used = Used {
            fingertip_power: self.fingertip.used_at(now),
            supply: share(self.supply_now(), u64::from(self.limits.supply.0)),
            ..Used::default()
        };
        let widest = u64::from(self.widest().get());
        for (index, wire) in self.wires.iter().enumerate() {
            let on = wire
                .now
                .map_or(0, |running| u64::from(running.setting.width()));
            used.pulse = used.pulse.max(share(on, widest));
            let burst = self.burst_at(index, now);
            let so_far = burst.until(now).since(burst.start).as_micros();
            let most = self.latest(&burst).since(burst.start).as_micros();
            used.burst = used.burst.max(share(so_far, most));
            let energy = share(burst.spent_nj, self.limits.burst_energy_nj);
            used.burst_energy = used.burst_energy.max(energy);
            used.wire_power = used.wire_power.max(wire.power.used_at(now));
        }
        if let Some(heat) = &self.heat {
            for tissue in &heat.tissues {
                tissue.add_used(&heat.budget, now, &mut used);
            }
        }
        used
    }

    /// The current, mA, of all wires that are on, at their worst instant.
    fn supply_now(&self) -> u64 {
        self.supply_peak(|wire| self.wires[wire].now.map(|now| now.setting))
    }
}

#[cfg(test)]
#[path = "used_tests.rs"]
mod tests;
