//! Energy that fades at fourteen rates at once: the effect of a stretch of time, and the addition of a burst.
//!
//! Sums are taken in the order of the rates and never reordered, so that every machine predicts the same bits.

use crate::units::Duration;

use super::table::{DECAYS, SLOWEST};

/// One number per decay.
pub(super) type Decays = [f64; DECAYS];

/// Rates of the decays, 1/s.
pub(super) const RATES: Decays = {
    let mut rates = [SLOWEST; DECAYS];
    let mut k = 1;
    while k < DECAYS {
        rates[k] = 2.0 * rates[k - 1];
        k += 1;
    }
    rates
};

/// The effect of a stretch of time on the decays.
#[derive(Clone, Copy, Debug)]
pub(super) struct Stretch {
    pub(super) span: Duration,
    pub(super) seconds: f64,
    /// Share that is left of energy from before the stretch.
    left: Decays,
    /// Share that is left at the end of energy spread over the stretch.
    pub(super) kept: Decays,
}

impl Stretch {
    pub(super) fn new(span: Duration) -> Self {
        let seconds = span.as_secs_f64();
        let mut left = [libm::exp(-SLOWEST * seconds); DECAYS];
        for k in 1..DECAYS {
            let slower = left[k - 1];
            left[k] = slower * slower;
        }
        let mut kept = [1.0; DECAYS];
        if span > Duration::ZERO {
            for ((kept, left), rate) in kept.iter_mut().zip(&left).zip(&RATES) {
                *kept = (1.0 - left) / (rate * seconds);
            }
        }
        Self {
            span,
            seconds,
            left,
            kept,
        }
    }

    /// Energies at the end of the stretch, J.
    pub(super) fn end(&self, energy: &Decays, joules: f64) -> Decays {
        core::array::from_fn(|k| energy[k] * self.left[k] + joules * self.kept[k])
    }

    /// Time integral over the stretch of what coefficients, K/J, make of the energies, K s.
    pub(super) fn integral(&self, coefficients: &Decays, energy: &Decays, joules: f64) -> f64 {
        let term = |k: usize| {
            let old = energy[k] * (1.0 - self.left[k]);
            coefficients[k] / RATES[k] * (old + joules * (1.0 - self.kept[k]))
        };
        (0..DECAYS).map(term).sum()
    }
}

/// The last few stretches: wires share them, and a steady cadence comes back to them.
#[derive(Clone, Copy, Debug)]
pub(super) struct Stretches {
    last: [Stretch; 4],
    oldest: usize,
}

impl Stretches {
    pub(super) fn new() -> Self {
        Self {
            last: [Stretch::new(Duration::ZERO); 4],
            oldest: 0,
        }
    }

    pub(super) fn stretch(&mut self, span: Duration) -> &Stretch {
        let known = self.last.iter().position(|s| s.span == span);
        let place = known.unwrap_or_else(|| {
            let place = self.oldest;
            self.oldest = (place + 1) % self.last.len();
            self.last[place] = Stretch::new(span);
            place
        });
        &self.last[place]
    }
}

/// One sum over the decays.
pub(super) fn dot(coefficients: &Decays, energy: &Decays) -> f64 {
    coefficients.iter().zip(energy).map(|(a, b)| a * b).sum()
}

/// Several sums over the same decays, side by side: each is one chain of additions, and a machine does them in the
/// time of one.
#[derive(Clone, Copy, Debug)]
pub(super) struct Sums<const N: usize> {
    /// Coefficients by decay, then by sum.
    columns: [[f64; N]; DECAYS],
}

impl<const N: usize> Sums<N> {
    /// Sums with the coefficients of each.
    pub(super) fn new(rows: [Decays; N]) -> Self {
        Self {
            columns: core::array::from_fn(|k| rows.map(|row| row[k])),
        }
    }

    /// Evaluates every sum for `energy`.
    pub(super) fn evaluate(&self, energy: &Decays) -> [f64; N] {
        let mut sums = [0.0; N];
        for (column, energy) in self.columns.iter().zip(energy) {
            for (sum, coefficient) in sums.iter_mut().zip(column) {
                *sum += coefficient * energy;
            }
        }
        sums
    }
}

#[cfg(test)]
#[path = "decays_tests.rs"]
mod tests;
