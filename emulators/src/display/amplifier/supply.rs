//! The supply behind any number of amplifiers: how far its voltage sags, what that leaves for each wire, and the
//! largest current it ever gave.

use palpate_core::units::Milliamps;

use crate::time::Nanos;

/// A supply with a resistance of its own, leads included.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SupplySource {
    /// Voltage without load, V; infinite for one that always suffices.
    pub volts: f64,
    /// Resistance in front of all amplifiers, Ohm.
    pub ohm: f64,
}

impl SupplySource {
    /// Gives every load its current: what it asks for, or what the sagging voltage drives through it.
    ///
    /// The voltage is that of the one operating point: the load that needs the most voltage falls out of regulation
    /// first, so loads are tried in that order.
    pub fn share(&self, loads: &mut [Load]) {
        for load in &mut *loads {
            load.amps = load.asked;
        }
        if self.volts == f64::INFINITY {
            return;
        }
        loop {
            let (mut regulated, mut conductance) = (0.0, 0.0);
            for load in &*loads {
                if load.amps < load.asked {
                    conductance += 1.0 / load.ohm;
                } else {
                    regulated += load.asked;
                }
            }
            let volts =
                ((self.volts - self.ohm * regulated) / (1.0 + self.ohm * conductance)).max(0.0);
            let still = loads
                .iter_mut()
                .filter(|l| l.amps >= l.asked && l.asked > 0.0);
            let hungriest = still.max_by(|a, b| a.needs().total_cmp(&b.needs()));
            match hungriest {
                Some(load) if load.needs() > volts => load.amps = 0.0,
                _ => {
                    for load in loads.iter_mut().filter(|l| l.amps < l.asked) {
                        load.amps = (volts / load.ohm).min(load.asked);
                    }
                    return;
                }
            }
        }
    }
}

/// A wire and its amplifier as the supply sees them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Load {
    /// Current that the amplifier is set to, A; 0 while it is off.
    pub asked: f64,
    /// Wire, leads and the amplifier's on-resistance, Ohm; above zero.
    pub ohm: f64,
    /// Current that flows, A.
    pub amps: f64,
}

impl Load {
    /// Voltage under which the amplifier loses regulation, V.
    fn needs(&self) -> f64 {
        self.asked * self.ohm
    }
}

/// The supply's current over time and the peak of it.
///
/// Changes at the same nanosecond count together: one wire off and the next one on is no peak.
#[derive(Clone, Copy, Debug, Default)]
pub struct Supply {
    now: Milliamps,
    at: Nanos,
    peak: Milliamps,
    peak_at: Nanos,
}

impl Supply {
    /// Sets the sum over all boards from `at` on. Times do not go backwards.
    pub fn set(&mut self, at: Nanos, sum: Milliamps) {
        if at > self.at {
            self.settle();
            self.at = at;
        }
        self.now = sum;
    }

    /// Current that flows now.
    pub const fn current(&self) -> Milliamps {
        self.now
    }

    /// The largest current so far and when it first flowed.
    pub fn peak(&self) -> (Milliamps, Nanos) {
        let mut settled = *self;
        settled.settle();
        (settled.peak, settled.peak_at)
    }

    fn settle(&mut self) {
        if self.now > self.peak {
            (self.peak, self.peak_at) = (self.now, self.at);
        }
    }
}

#[cfg(test)]
#[allow(clippy::float_cmp)] // exact by construction
#[path = "supply_tests.rs"]
mod tests;
