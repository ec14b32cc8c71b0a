//! Temperature of tissue without a wire's heat: skin at rest, or under a warm face of a Peltier module.
//!
//! A face that is colder than skin at rest relieves nothing: the wires' rows are never looser than without it.

use crate::units::{Duration, Instant};

use super::Guard;
use super::kernel::REST_C;

/// Length of a bin.
const BIN: Duration = Duration::from_millis(1000);
/// Bins kept: the window of the mean, and the seconds in which tissue at 0.4 mm forgets a warmer face.
const BINS: usize = 14;

/// The warmest face of the last seconds.
#[derive(Clone, Debug, Default)]
pub(super) struct Rest {
    /// Warmest face above rest, K, by bin of absolute time, the newest first.
    bins: [f64; BINS],
    /// Number of the newest bin.
    newest: u64,
    /// Warmest of the session, K.
    pub(super) most_k: f64,
}

impl Rest {
    /// The tissue's rest in force, K above skin at rest.
    pub(super) fn k(&self) -> f64 {
        self.bins.into_iter().fold(0.0, f64::max)
    }

    /// Raises the face to at least `k` from now on. A lower face counts once the bins before are over.
    pub(super) fn raise(&mut self, at: Instant, k: f64) {
        let bin = at.as_micros() / BIN.as_micros();
        let passed = bin.saturating_sub(self.newest).min(BINS as u64) as usize;
        self.bins.copy_within(..BINS - passed, passed);
        self.bins[..passed].fill(0.0);
        self.newest = self.newest.max(bin);
        self.bins[0] = self.bins[0].max(k);
        self.most_k = self.most_k.max(k);
    }
}

impl Guard {
    /// Tells the guard of a face on the skin that may be as warm as `face_c` and shall become `wanted_c`, degrees C.
    /// From now on bursts are measured against the warmer of both, and predictions count from the face, for as long
    /// as tissue remembers it. Not a number counts as far too warm.
    ///
    /// Returns the warmest that the face may become now, degrees C: with it, what is booked keeps to every limit. A
    /// guard without thermal rows bears no face warmer than skin at rest.
    pub fn warm(&mut self, at: Instant, face_c: f64, wanted_c: f64) -> f64 {
        let Some(heat) = &mut self.heat else {
            return REST_C;
        };
        let rest_c = heat.budget.kernel.rest_c;
        let above = |c: f64| match c.is_nan() {
            true => f64::INFINITY,
            false => (c - rest_c).max(0.0),
        };
        heat.rest.raise(at, above(face_c));
        let face_k = heat.rest.k();
        let mut bears_k = f64::INFINITY;
        for tissue in &mut heat.tissues {
            let (predicted, k) = tissue.bears(&heat.budget, at, face_k);
            // A face that is no warmer than before changes nothing of what was predicted with each booking.
            if face_k > tissue.face_k {
                heat.predicted.raise(&predicted);
            }
            bears_k = bears_k.min(k);
            tissue.face_k = face_k;
            tissue.rest_k = face_k.max(above(wanted_c));
        }
        rest_c + bears_k.max(0.0)
    }
}

#[cfg(test)]
#[path = "rest_tests.rs"]
mod tests;
