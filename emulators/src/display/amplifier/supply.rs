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
    /// What flows, A.
    pub amps: f64,
}

impl Load {
    /// Voltage under which it loses regulation, V.
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
    /// The sum over all boards from `at` on. Times do not go backwards.
    pub fn set(&mut self, at: Nanos, sum: Milliamps) {
        if at > self.at {
            self.settle();
            self.at = at;
        }
        self.now = sum;
    }

    /// What flows now.
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
mod tests {
    use super::*;

    fn loads(asked: &[f64], ohm: f64) -> Vec<Load> {
        let load = |&asked: &f64| Load {
            asked,
            ohm,
            amps: 0.0,
        };
        asked.iter().map(load).collect()
    }

    #[test]
    fn a_supply_sags_with_the_wires_that_are_on() {
        // 5 V behind 0.2 Ohm, wires of 1.9 Ohm behind 0.1 Ohm: 4 V for 2 A.
        let source = SupplySource {
            volts: 5.0,
            ohm: 0.2,
        };
        let mut two = loads(&[2.0, 2.0, 0.0], 2.0);
        source.share(&mut two);
        assert!(two[0].amps == 2.0 && two[1].amps == 2.0 && two[2].amps == 0.0);
        // Eight at once: V = 5 / (1 + 0.2 * 8 / 2) = 2.78 V, 1.39 A each.
        let mut eight = loads(&[2.0; 8], 2.0);
        source.share(&mut eight);
        assert!(
            eight
                .iter()
                .all(|l| (l.amps - 5.0 / 1.8 / 2.0).abs() < 1e-12)
        );
        let stiff = SupplySource {
            volts: f64::INFINITY,
            ohm: 0.0,
        };
        stiff.share(&mut eight);
        assert!(eight.iter().all(|l| l.amps == 2.0));
    }

    #[test]
    fn the_hungriest_wire_gives_way_first() {
        let source = SupplySource {
            volts: 4.0,
            ohm: 0.5,
        };
        let mut unlike = loads(&[1.0, 1.0], 1.0);
        unlike[1].ohm = 5.0;
        source.share(&mut unlike);
        // V = (4 - 0.5) / (1 + 0.5 / 5) = 3.18 V: enough for the first, not for the second.
        let volts = 3.5 / 1.1;
        assert!(unlike[0].amps == 1.0 && (unlike[1].amps - volts / 5.0).abs() < 1e-12);
        // What flows through the source explains the voltage at the wires.
        let sum: f64 = unlike.iter().map(|l| l.amps).sum();
        assert!((4.0 - 0.5 * sum - volts).abs() < 1e-12);
    }

    #[test]
    fn the_supply_peak_is_over_all_wires_and_not_over_a_handover() {
        let mut supply = Supply::default();
        supply.set(Nanos(10), Milliamps(300));
        supply.set(Nanos(20), Milliamps(600)); // the next one on and the first one off in one nanosecond
        supply.set(Nanos(20), Milliamps(300));
        assert_eq!(supply.peak(), (Milliamps(300), Nanos(10)));
        supply.set(Nanos(30), Milliamps(600));
        supply.set(Nanos(40), Milliamps(300));
        assert_eq!(supply.peak(), (Milliamps(600), Nanos(30)));
        assert_eq!(supply.current(), Milliamps(300));
    }
}
