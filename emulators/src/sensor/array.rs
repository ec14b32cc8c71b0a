//! A skin that no emulated bus carries: a camera, a body, or boards that another machine reads. Whole scans of all
//! modules come at one rate, over a network late and with losses where it is said so.

use std::collections::VecDeque;
use std::convert::Infallible;

use palpate_core::codec::uskin::Reading;
use palpate_core::random::RandomStream;
use palpate_core::skin::{ModuleScan, SkinSource, TakeScan};
use palpate_core::units::Instant;

use super::module::EmulatedModule;
use crate::time::Nanos;

/// Delivery of scans to the host.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Delivery {
    /// Shortest delay, s.
    pub delay_s: f64,
    /// Largest delay that is added to it, s, drawn evenly from zero. A scan never overtakes the one before it.
    pub jitter_s: f64,
    /// Share of scans that come later still, and by how much, s.
    pub late: (f64, f64),
    /// Share of scans that never arrive.
    pub loss: f64,
}

impl Delivery {
    /// Delivery at once and whole.
    pub const DIRECT: Self = Self {
        delay_s: 0.0,
        jitter_s: 0.0,
        late: (0.0, 0.0),
        loss: 0.0,
    };
}

/// A scan of all modules on its way.
struct OnItsWay {
    arrives: Nanos,
    counts: Vec<[u16; 3]>,
}

/// An emulated skin without boards.
pub struct SkinArray {
    modules: Vec<EmulatedModule>,
    period_ns: f64,
    delivery: Delivery,
    chance: RandomStream,
    /// Scans taken so far.
    taken: u64,
    /// Arrival of the newest scan.
    newest: Nanos,
    way: VecDeque<OnItsWay>,
    /// Memory of scans that have arrived, and of readings.
    spare: Vec<Vec<[u16; 3]>>,
    readings: Vec<Reading>,
    lost: u64,
}

impl SkinArray {
    /// Modules that are scanned together `rate_hz` times per second from the start on; `seed` decides which scans are
    /// late or lost.
    pub fn new(modules: Vec<EmulatedModule>, rate_hz: f64, delivery: Delivery, seed: u64) -> Self {
        Self {
            modules,
            period_ns: 1e9 / rate_hz,
            delivery,
            chance: RandomStream::new(seed, "delivery of scans"),
            taken: 0,
            newest: Nanos::ZERO,
            way: VecDeque::new(),
            spare: Vec::new(),
            readings: Vec::new(),
            lost: 0,
        }
    }

    /// Scans that never arrived.
    pub const fn lost(&self) -> u64 {
        self.lost
    }

    /// Lets time pass until `to`: every scan that is due by then is taken and sent.
    pub fn advance(&mut self, to: Nanos) {
        loop {
            let due = Nanos(libm::rint(self.taken as f64 * self.period_ns) as u64);
            if due > to {
                return;
            }
            self.taken += 1;
            let mut counts = self.spare.pop().unwrap_or_default();
            counts.clear();
            for module in &mut self.modules {
                module.sample(due, &mut self.readings);
                counts.extend(self.readings.iter().map(|r| [r.x, r.y, r.z]));
            }
            // Drawn for every scan, so that one that is lost changes no other.
            let [jitter, held, luck] = std::array::from_fn(|_| self.chance.uniform());
            if luck < self.delivery.loss {
                self.lost += 1;
                self.spare.push(counts);
                continue;
            }
            let (share, late_s) = self.delivery.late;
            let held_s = if held < share { late_s } else { 0.0 };
            let way_s = self.delivery.delay_s + jitter * self.delivery.jitter_s + held_s;
            self.newest = self.newest.max(due + Nanos((way_s * 1e9) as u64));
            self.way.push_back(OnItsWay {
                arrives: self.newest,
                counts,
            });
        }
    }
}

impl SkinSource for SkinArray {
    type Error = Infallible;

    fn scans(&mut self, now: Instant, take: &mut TakeScan<'_>) -> Result<(), Infallible> {
        while let Some(scan) = self.way.pop_front_if(|scan| scan.arrives <= now.into()) {
            let at = Instant::from_micros(scan.arrives.as_micros());
            let mut from = 0;
            for (number, module) in (0..).zip(&self.modules) {
                let to = from + module.config().taxels.len();
                take(&ModuleScan::whole(number, at, &scan.counts[from..to]));
                from = to;
            }
            self.spare.push(scan.counts);
        }
        Ok(())
    }
}

#[cfg(test)]
#[path = "array_tests.rs"]
mod tests;
