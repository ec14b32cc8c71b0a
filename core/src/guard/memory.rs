//! State that outlives a guard: heat and dose of the tissue and the power that was spent, in constant size. A guard
//! that goes on from it has the limits that one long run would have.
//!
//! A burst is left out: none is on between two runs.

use alloc::boxed::Box;
use alloc::vec::Vec;

use super::dose::{Dose, Doses};
use super::kernel::{Kernel, REST_C};
use super::power::Spent;
use super::table::{DECAYS, LATENT_K};
use super::thermal::{BIN_US, BINS, Budget, Tissue};
use super::{Booked, Guard};
use crate::units::{Duration, Instant};

/// Longest time from a booking to now, about 30 years: sums of times stay within their type.
const LONGEST: Duration = Duration::from_millis(1_000_000_000_000);
/// Furthest time ahead for which a burst is booked.
const AHEAD: Duration = Duration::from_millis(60_000);
/// Largest energy, temperature or dose, in any of the units here.
const MOST: f64 = 1e6;

/// State that outlives a guard. The default is a display that was never driven.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Memory {
    /// Memory of each wire, in the display's order.
    pub wires: Box<[WireMemory]>,
    /// Energy spent of the fingertip's mean power.
    pub tip: Spent,
    /// The most by which the face of a Peltier module was warmer than skin at rest in the last seconds, K.
    pub face_k: f64,
}

/// Heat, dose and power of one wire.
#[derive(Clone, Debug, PartialEq)]
pub struct WireMemory {
    /// Time of this state, in the time of [`Self::at`].
    pub now: Instant,
    /// The time up to which everything is booked.
    pub at: Instant,
    /// Energy that each decay of the tissue still feels, J.
    pub energy_j: [f64; DECAYS],
    /// Time integral of the temperature above rest at 0.1 mm, K s, by bin of 250 ms of that time, the last one first.
    pub bins_ks: [f64; BINS],
    /// Dose of the tissue.
    pub doses: Doses,
    /// Upper bound of the tissue's temperature so far, degrees C, whatever the energies tell; `None` where they tell
    /// it.
    pub most_c: Option<f64>,
    /// Energy spent of the wire's mean power.
    pub power: Spent,
}

/// Figures that no guard can have written.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("expected heat and dose in finite figures from zero on, and no booking far ahead")]
pub struct MemoryError;

impl Spent {
    fn after(self, elapsed: Duration) -> Self {
        Self {
            ago: self.ago + elapsed,
            ..self
        }
    }
}

/// A wire that was never driven.
impl Default for WireMemory {
    fn default() -> Self {
        Tissue::new(REST_C).memory(Instant::ZERO, Spent::default())
    }
}

impl WireMemory {
    /// The memory after so much time without heat. Where the time is unknown nothing has cooled.
    #[must_use]
    pub fn after(&self, elapsed: Option<Duration>) -> Self {
        let elapsed = elapsed.unwrap_or(Duration::ZERO);
        Self {
            now: self.now + elapsed,
            power: self.power.after(elapsed),
            ..self.clone()
        }
    }

    /// Checks that a guard can have written it.
    ///
    /// # Errors
    /// [`MemoryError`] if no guard can have.
    pub fn check(&self) -> Result<(), MemoryError> {
        let doses = [self.doses.omega, self.doses.cem43_min];
        let figures = self.energy_j.iter().chain(&self.bins_ks).chain(&doses);
        let mut figures = figures.chain(&self.most_c);
        let is_whole = figures.all(is_figure) && self.at <= self.now + AHEAD;
        is_whole.then_some(()).ok_or(MemoryError)
    }
}

/// Returns true for a figure of heat: finite, not negative and at most [`MOST`].
fn is_figure(figure: &f64) -> bool {
    (0.0..=MOST).contains(figure)
}

impl Memory {
    /// The memory after so much time without heat. Where the time is unknown nothing has cooled.
    #[must_use]
    pub fn after(&self, elapsed: Option<Duration>) -> Self {
        Self {
            wires: self.wires.iter().map(|wire| wire.after(elapsed)).collect(),
            tip: self.tip.after(elapsed.unwrap_or(Duration::ZERO)),
            face_k: self.face_k,
        }
    }

    /// The most dose under any wire.
    #[must_use]
    pub fn doses(&self) -> Doses {
        let doses = self.wires.iter().map(|wire| wire.doses);
        doses.fold(Doses::default(), Doses::max)
    }
}

impl Tissue {
    /// The wire's state as of `at` of its run.
    fn memory(&self, at: Instant, power: Spent) -> WireMemory {
        WireMemory {
            now: at + self.begun,
            at: self.at,
            energy_j: self.energy,
            // A rounding error may have left a bin of nothing below zero.
            bins_ks: self.bins.map(|bin| bin.max(0.0)),
            // Power far beyond any limit counts as spent in any case.
            doses: Doses {
                omega: self.dose.omega.min(MOST),
                cem43_min: self.dose.cem43_min.min(MOST),
            },
            most_c: Some(self.most_c).filter(|c| c.is_finite()),
            power,
        }
    }

    /// Restores tissue as of `at` of this run from the memory of another run. The bins keep their place in time, and
    /// windows begin after the beginning of time.
    fn recalled(kernel: &Kernel, memory: &WireMemory, at: Instant, face_k: f64) -> Self {
        let (behind, ahead) = (memory.now.since(memory.at), memory.at.since(memory.now));
        let bins = (at + ahead).as_micros().div_ceil(BIN_US) + BINS as u64;
        let within = Duration::from_micros(memory.at.as_micros() % BIN_US);
        let booked = Instant::from_micros(bins.saturating_mul(BIN_US)) + within;
        let now = (booked + behind.min(LONGEST)) - ahead;
        let mut tissue = Self {
            at: booked,
            begun: now.since(at),
            energy: memory.energy_j,
            bins: memory.bins_ks,
            most_c: memory.most_c.unwrap_or(f64::INFINITY),
            face_k,
            rest_k: face_k,
            ..Self::new(kernel.rest_c)
        };
        tissue.dose = Dose::at(memory.doses, tissue.shallow_c(kernel));
        tissue
    }

    /// The tissue at `end` of its run, from above for any heat of at most `joules` from `at` until then. Tissue
    /// answers a joule the less the older it is, so all of it counts at the end. Until then tissue keeps to the peak,
    /// or to its own temperature if that is higher.
    fn reserved(&self, budget: &Budget, (at, end): (Instant, Instant), joules: f64) -> Self {
        let (mut tissue, mut stretches) = (self.clone(), budget.stretches);
        let rest_c = budget.kernel.rest_c + LATENT_K[0];
        let most_c = self.shallow_c(&budget.kernel).max(rest_c + budget.peak_k);
        let until = self.at.max(end + self.begun);
        tissue.relax((&budget.kernel, &mut stretches), until);
        let first = (at + self.begun).as_micros() / BIN_US;
        let bins = until.as_micros().div_ceil(BIN_US).saturating_sub(first);
        for bin in tissue.bins.iter_mut().take(bins as usize) {
            *bin = bin.max((most_c - rest_c) * BIN_US as f64 * 1e-6);
        }
        for energy in &mut tissue.energy {
            *energy += joules;
        }
        tissue.dose.heat(most_c, end.since(at).as_secs_f64());
        tissue.most_c = most_c;
        tissue
    }
}

impl Guard {
    /// The guard's state as of `at`.
    pub fn memory(&self, at: Instant) -> Memory {
        self.recorded(at, |wire, tissue| {
            tissue.memory(at, self.wires[wire].power.spent(at))
        })
    }

    /// The most that [`Self::memory`] may become until a `span` after `at`, and for a burst more, whatever is driven.
    /// A program that dies leaves this on disk. All power is spent then.
    pub fn reserve(&self, at: Instant, span: Duration) -> Memory {
        let end = at + span;
        // The last burst may begin at the end of the span.
        let reach = self.limits.burst + self.surplus() + self.plant.latency();
        let tip_nj = self.fingertip.most_nj(at, span);
        let reserved = self.recorded(end, |wire, tissue| {
            let Some(heat) = &self.heat else {
                return tissue.memory(end, Spent::ALL);
            };
            let own_nj = self.wires[wire].power.most_nj(at, span).min(tip_nj);
            let joules = own_nj.saturating_add(self.limits.burst_energy_nj) as f64 * 1e-9;
            let reserved = tissue.reserved(&heat.budget, (at, end + reach), joules);
            reserved.memory(end, Spent::ALL)
        });
        Memory {
            tip: Spent::ALL,
            ..reserved
        }
    }

    /// The guard's state as of `at`, wire by wire.
    fn recorded(&self, at: Instant, of: impl Fn(usize, &Tissue) -> WireMemory) -> Memory {
        // Without thermal rows nothing is known of any tissue.
        let unknown = Tissue::new(REST_C);
        let tissue = |wire: usize| self.heat.as_ref().and_then(|heat| heat.tissues.get(wire));
        let wires = 0..self.wires.len();
        let wires = wires.map(|wire| of(wire, tissue(wire).unwrap_or(&unknown)));
        Memory {
            wires: wires.collect(),
            tip: self.fingertip.spent(at),
            face_k: self.heat.as_ref().map_or(0.0, |heat| heat.rest.k()),
        }
    }

    /// Restores the memory of another guard as of `at`, in a guard that has passed nothing yet. Wires that this guard
    /// lacks are left out, and those that the other one lacked are cold.
    ///
    /// # Errors
    /// [`MemoryError`] for figures that no guard can have written. The guard stays unchanged then.
    pub fn remember(&mut self, memory: &Memory, at: Instant) -> Result<(), MemoryError> {
        memory.wires.iter().try_for_each(WireMemory::check)?;
        if !is_figure(&memory.face_k) {
            return Err(MemoryError);
        }
        self.fingertip.recall(&memory.tip, at);
        for (state, wire) in self.wires.iter_mut().zip(&memory.wires) {
            state.power.recall(&wire.power, at);
        }
        if let Some(heat) = &mut self.heat {
            heat.rest.raise(at, memory.face_k);
            for (tissue, wire) in heat.tissues.iter_mut().zip(&memory.wires) {
                *tissue = Tissue::recalled(&heat.budget.kernel, wire, at, memory.face_k);
                let (predicted, _) = tissue.bears(&heat.budget, at, memory.face_k);
                heat.predicted.raise(&predicted);
            }
        }
        Ok(())
    }

    /// Books bursts that another guard has passed in a run that began at `began`, in order of time. Returns the end
    /// of the last of them. Wires that this guard lacks are left out.
    pub fn repeat(&mut self, began: Instant, bursts: &[(u16, Booked)]) -> Instant {
        let (latency, shift) = (self.plant.latency(), began.since(Instant::ZERO));
        let mut bursts: Vec<_> = bursts.iter().collect();
        bursts.sort_by_key(|(_, burst)| burst.on);
        let mut over = began;
        for (wire, burst) in bursts {
            let (on, off) = (burst.on + shift, burst.off + shift);
            over = over.max(off);
            let index = usize::from(*wire);
            let Some(state) = self.wires.get_mut(index) else {
                continue;
            };
            for bucket in [&mut state.power, &mut self.fingertip] {
                bucket.left_nj(on);
                bucket.spend(burst.energy_nj);
            }
            if let Some(heat) = &mut self.heat {
                let tissue = &mut heat.tissues[index];
                let booking = tissue.booking(on, off, latency);
                let joules = burst.energy_nj as f64 * 1e-9;
                let predicted = tissue.heat(&mut heat.budget, booking, joules);
                heat.predicted.raise(&predicted);
            }
        }
        over
    }
}

#[cfg(test)]
#[path = "memory_tests.rs"]
mod tests;
