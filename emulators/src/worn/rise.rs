//! Tissue that a warm face raises: beside what wires do to it, the face's own excess over skin at rest.
//!
//! Heat conduction is linear, so both add. Tissue under a wire is taken to be as warm as the face at once, and a dose to
//! come at the hottest of each stretch between two samples: both from above. What a cold face takes away is left out.

use std::collections::VecDeque;

use super::totals::DisplayTotals;
use super::{MEAN_WINDOW, START_C, ThermalSample};
use crate::display::finger::dose::{cem43_rate, omega_rate};
use crate::time::Nanos;

/// The excess of a face over skin at rest, K, over time.
#[derive(Clone, Debug, Default)]
pub(super) struct Rise {
    at: Nanos,
    /// Now.
    pub(super) k: f64,
    /// Largest excess since the last sample.
    most_k: f64,
    /// Time integral, K s.
    k_s: f64,
    /// Time integral at past samples, K s, for the mean.
    past: VecDeque<(Nanos, f64)>,
    sampled: Nanos,
    /// Hottest tissue at 0.1 and at 0.4 mm, degrees C.
    hottest_c: (f64, f64),
    /// Henriques' Omega, and minutes at 43 C.
    dose: (f64, f64),
}

impl Rise {
    /// Sets the face to `celsius` from `now` on.
    pub(super) fn set(&mut self, now: Nanos, celsius: f64) {
        self.pass(now);
        self.k = (celsius - START_C).max(0.0);
        self.most_k = self.most_k.max(self.k);
    }

    fn pass(&mut self, now: Nanos) {
        self.k_s += self.k * now.since(self.at).as_secs_f64();
        self.at = self.at.max(now);
    }

    /// Adds it to a sample of the wires' own heat.
    pub(super) fn add(&mut self, sample: ThermalSample) -> ThermalSample {
        self.pass(sample.at);
        let begin = sample.at.since(MEAN_WINDOW);
        while self.past.get(1).is_some_and(|next| next.0 <= begin) {
            self.past.pop_front();
        }
        let then = self.past.front().map_or(0.0, |past| past.1);
        let mean_k = (self.k_s - then) / MEAN_WINDOW.as_secs_f64();
        self.past.push_back((sample.at, self.k_s));
        let most_k = std::mem::replace(&mut self.most_k, self.k);
        let warmed = ThermalSample {
            shallow_c: sample.shallow_c + most_k,
            deep_c: sample.deep_c + most_k,
            mean_c: sample.mean_c + mean_k,
            ..sample
        };
        let seconds = sample.at.since(self.sampled).as_secs_f64();
        self.sampled = sample.at;
        self.hottest_c.0 = self.hottest_c.0.max(warmed.shallow_c);
        self.hottest_c.1 = self.hottest_c.1.max(warmed.deep_c);
        self.dose.0 += omega_rate(warmed.shallow_c) * seconds;
        self.dose.1 += cem43_rate(warmed.shallow_c) * seconds;
        warmed
    }

    /// The totals with it, where they were sampled.
    pub(super) fn total(&self, totals: DisplayTotals) -> DisplayTotals {
        DisplayTotals {
            hottest_tissue_c: totals.hottest_tissue_c.max(self.hottest_c.0),
            hottest_deep_c: totals.hottest_deep_c.max(self.hottest_c.1),
            dose: (
                totals.dose.0.max(self.dose.0),
                totals.dose.1.max(self.dose.1),
            ),
            ..totals
        }
    }
}
