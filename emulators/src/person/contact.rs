//! How well each wire of a display touches the tissue: a seeded factor that varies slowly with time.
//!
//! The published users felt jumps and deviations that their author puts down to irregular contact: a finger
//! moves in a rigid module. How much has not been measured. **Assumed**: per person and wire a constant factor
//! that spreads by 15 %, times a drift of 20 % over 3 to 12 seconds that differs from trial to trial.

use palpate_core::random::RandomStream;

/// Spread of a person's factor from wire to wire, natural logarithm.
const PERSON: f64 = 0.15;
/// Root mean square of the drift within a trial, natural logarithm.
const DRIFT: f64 = 0.2;
/// Waves that make a drift.
const WAVES: usize = 4;

/// One wire's contact.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Contact {
    constant: f64,
    /// Angular frequency in 1/s and phase of each wave.
    waves: [(f64, f64); WAVES],
}

/// The contact of every wire with one person's tissue in one trial.
#[derive(Clone, Debug, PartialEq)]
pub struct WireContacts {
    wires: Vec<Contact>,
}

impl WireContacts {
    /// Of `wires` wires. The person's constant part is the same in all their trials.
    pub fn new(seed: u64, person: u32, trial: u32, wires: usize) -> Self {
        let contact = |wire: usize| {
            let constant =
                RandomStream::new(seed, &format!("person {person} wire {wire}")).normal();
            let identity = format!("person {person} trial {trial} wire {wire}");
            let mut drift = RandomStream::new(seed, &identity);
            let waves = core::array::from_fn(|_| {
                let period_s = 3.0 + 9.0 * drift.uniform();
                let phase = core::f64::consts::TAU * drift.uniform();
                (core::f64::consts::TAU / period_s, phase)
            });
            Contact {
                constant: PERSON * constant,
                waves,
            }
        };
        Self {
            wires: (0..wires).map(contact).collect(),
        }
    }

    /// What a wire's displacement is multiplied by at a time, 1 where there is no such wire.
    pub fn factor(&self, wire: usize, seconds: f64) -> f64 {
        let Some(contact) = self.wires.get(wire) else {
            return 1.0;
        };
        // Each wave has a mean square of one half.
        let height = DRIFT * libm::sqrt(2.0 / WAVES as f64);
        let wave = |&(rate, phase): &(f64, f64)| libm::sin(rate * seconds + phase);
        let drift: f64 = contact.waves.iter().map(wave).sum();
        libm::exp(contact.constant + height * drift)
    }
}

#[cfg(test)]
#[allow(clippy::float_cmp)] // exact by construction
#[path = "contact_tests.rs"]
mod tests;
