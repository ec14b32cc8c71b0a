//! The length that a session may last before the dose row begins to fade bursts that come over and over.
//!
//! The tissue's memory is linear: after m rounds of the same bursts each decay holds its energy of one round times a
//! geometric sum. A few dozen rounds therefore give a day of them, at the temperatures by which the guard decides.

use crate::schedule::Entry;
use crate::units::{Duration, Instant, Ticks};

use super::Guard;
use super::decays::{Decays, RATES, Stretches, dot};
use super::dose::{Dose, Doses};
use super::kernel::Kernel;
use super::table::LATENT_K;

/// First stretch in which tissue is taken to cool along a chord. The guard's own chords end with bins of twice that
/// length, wherever a burst lies in one.
const STRIDE: Duration = Duration::from_millis(125);

/// A burst on one wire, as the guard books it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Booked {
    /// Time at which the wire goes on.
    pub on: Instant,
    /// Latest time at which it is off.
    pub off: Instant,
    /// Electrical energy, nJ, from above over all oscillators.
    pub energy_nj: u64,
}

/// One round of bursts.
struct Round {
    /// Energy that each decay holds at the end of the round, J.
    energy: Decays,
    /// Dose of this round alone.
    dose: Dose,
    /// Dose below which the guard would make the mean burst weaker.
    kept: Doses,
    /// Temperature of the tissue without a wire's heat, K above skin at rest.
    rest_k: f64,
    kernel: Kernel,
}

/// Temperature of tissue 0.1 mm deep, degrees C, `rest_k` kelvin above skin at rest without a wire's heat.
fn shallow_c(kernel: &Kernel, energy: &Decays, rest_k: f64) -> f64 {
    kernel.rest_c + rest_k + LATENT_K[0] + dot(&kernel.shallow, energy)
}

impl Round {
    fn new(
        (bursts, period): (&[Booked], Duration),
        energy: Decays,
        (kernel, rest_k): (&Kernel, f64),
        known: &mut Stretches,
    ) -> Self {
        let mut round = Self {
            energy,
            rest_k,
            kernel: *kernel,
            dose: Dose::new(shallow_c(kernel, &energy, rest_k)),
            kept: Doses {
                omega: 0.0,
                cem43_min: 0.0,
            },
        };
        let (begun, mut now) = (
            bursts.first().map_or(Instant::ZERO, |b| b.on),
            Instant::ZERO,
        );
        for burst in bursts {
            let on = Instant::ZERO + burst.on.since(begun);
            round.relax(now, on, known);
            now = now.max(on);
            let span = (Instant::ZERO + burst.off.since(begun)).since(now);
            round.energy = known
                .stretch(span)
                .end(&round.energy, burst.energy_nj as f64 * 1e-9);
            round
                .dose
                .heat(shallow_c(kernel, &round.energy, rest_k), span.as_secs_f64());
            let kept = round.dose.kept_back();
            round.kept.omega += kept.omega / bursts.len() as f64;
            round.kept.cem43_min += kept.cem43_min / bursts.len() as f64;
            now += span;
        }
        round.relax(now, Instant::ZERO + period, known);
        round
    }

    fn relax(&mut self, mut now: Instant, to: Instant, known: &mut Stretches) {
        let mut stride = STRIDE;
        while now < to {
            let span = to.since(now).min(stride);
            self.energy = known.stretch(span).end(&self.energy, 0.0);
            let shallow_c = shallow_c(&self.kernel, &self.energy, self.rest_k);
            self.dose.relax(shallow_c, span.as_secs_f64());
            now += span;
            stride = stride + stride;
        }
    }
}

impl Guard {
    /// Books the entries of one wire, in order of time, as if they came over and over. Where amplifiers have their
    /// current set, each entry that goes on confirms its own.
    pub fn booked<'a>(
        &self,
        entries: impl DoubleEndedIterator<Item = &'a Entry> + Clone,
    ) -> impl Iterator<Item = Booked> {
        let is_on = |entry: &&Entry| entry.width() > Ticks::ZERO;
        let mut confirmed = entries.clone().rfind(is_on).and_then(|last| last.current);
        entries.map(move |entry| {
            let (width, span) = (entry.width(), entry.until.since(entry.at));
            let plant = self.counting_after(confirmed, entry.current);
            if is_on(&entry) {
                confirmed = entry.current;
            }
            Booked {
                on: entry.at,
                off: entry.until + self.surplus(),
                energy_nj: plant.energy_nj(width.get(), span),
            }
        })
    }

    /// Returns how long a session from rest may last in which a wire has these bursts, in order of time, again every
    /// `period`. It ends when so little of the dose is left that the guard would weaken the mean burst.
    ///
    /// Returns `None` if that takes `most` or longer, and for a guard without thermal rows. The tissue counts as warm
    /// as a face has ever made it. Other rows are left out. The period counts from the first burst; one that is
    /// shorter than all bursts is made as long as they are.
    pub fn lasts(&self, bursts: &[Booked], period: Duration, most: Duration) -> Option<Duration> {
        let begun = bursts.first()?.on;
        let all = bursts.iter().map(|b| b.off.since(begun)).max()?;
        let period = period.max(all).max(Duration::from_micros(1));
        let seconds = period.as_secs_f64();
        let heat = self.heat.as_ref()?;
        let (limits, rest) = (heat.budget.doses(), (&heat.budget.kernel, heat.rest.most_k));
        let mut known = Stretches::new();
        let round = |energy, known: &mut _| Round::new((bursts, period), energy, rest, known);
        let first = round(Decays::default(), &mut known);
        let energy = first.energy;
        let after = |rounds: u64| -> Decays {
            core::array::from_fn(|k| {
                let left = |n: f64| 1.0 - libm::exp(-RATES[k] * seconds * n);
                energy[k] * left(rounds as f64) / left(1.0)
            })
        };
        let last = most.as_micros() / period.as_micros();
        // No round has more dose than a later one.
        let hottest = round(after(last), &mut known);
        let (dose, kept, n) = (&hottest.dose, &hottest.kept, last as f64);
        if n * dose.omega + kept.omega <= limits.omega
            && n * dose.cem43_min + kept.cem43_min <= limits.cem43_min
        {
            return None;
        }
        let (mut rounds, mut here) = (0, first);
        let (mut omega, mut cem43_min) = (0.0, 0.0);
        while rounds <= last {
            let next = rounds + (rounds / 2).max(1);
            let there = round(after(next), &mut known);
            let n = (next - rounds) as f64;
            // Rounds between the two are taken to differ by even steps.
            let mean = |a: f64, b: f64| f64::midpoint(a, b);
            let more = (
                n * mean(here.dose.omega, there.dose.omega),
                n * mean(here.dose.cem43_min, there.dose.cem43_min),
            );
            let kept = &there.kept;
            let part = |used: f64, more: f64, limit: f64| ((limit - used) / more).max(0.0);
            let share = part(omega, more.0, limits.omega - kept.omega).min(part(
                cem43_min,
                more.1,
                limits.cem43_min - kept.cem43_min,
            ));
            if share < 1.0 {
                let s = (rounds as f64 + share * n) * seconds;
                return Some(Duration::from_millis((s * 1e3) as u64)).filter(|d| *d < most);
            }
            (omega, cem43_min) = (omega + more.0, cem43_min + more.1);
            (rounds, here) = (next, there);
        }
        None
    }
}

#[cfg(test)]
#[path = "lasting_tests.rs"]
mod tests;
