//! Marginal distributions of quantities: a prior, conditioned by what was measured of the quantity itself.
//!
//! Weights of many measured figures would leave a handful of draws. So a figure that has a prior is drawn from prior times
//! likelihood, exactly but for the rounding of a grid that closes in on where they lie.

use core::f64::consts::SQRT_2;

use palpate_files::{Bound, EvidenceRow, Prior};

/// Cells of a grid.
const CELLS: usize = 400;
/// Most times that a grid closes in.
const ZOOMS: usize = 12;
/// Logarithm of the likelihood, under the largest one, below which a cell does not count.
const NEGLIGIBLE: f64 = 30.0;
/// Cells that count from which on a grid is fine enough.
const FINE: usize = 60;
/// Least logarithm of a likelihood anywhere: ten standard deviations.
const NOWHERE: f64 = -50.0;

/// Logarithm of the likelihood of a row where its quantity has a value.
pub(super) fn log_likelihood(row: &EvidenceRow, value: f64) -> f64 {
    let z = match (row.tolerance, row.factor) {
        (Some([below, above]), _) => {
            let off = value - row.value;
            off / if off < 0.0 { below } else { above }
        }
        (None, Some([below, above])) => {
            let off = libm::log(value.max(1e-9) / row.value);
            off / libm::log(if off < 0.0 { below } else { above })
        }
        (None, None) => 0.0,
    };
    let one = match row.bound {
        Bound::Near => -0.5 * z * z,
        Bound::Over => log_phi(z),
        Bound::Under => log_phi(-z),
    };
    one * f64::from(row.times)
}

/// Standard normal distribution function.
fn phi(z: f64) -> f64 {
    0.5 * libm::erfc(-z / SQRT_2)
}

/// Logarithm of the distribution function; far below 0 by its asymptote, where the function itself is 0.
fn log_phi(z: f64) -> f64 {
    match z > -30.0 {
        true => libm::log(phi(z)),
        false => -0.5 * z * z - libm::log(-z * 2.506_628_274_631),
    }
}

/// Standard normal quantile, by halving.
fn quantile(p: f64) -> f64 {
    let (mut low, mut high) = (-9.0, 9.0);
    for _ in 0..60 {
        let middle = f64::midpoint(low, high);
        match phi(middle) < p {
            true => low = middle,
            false => high = middle,
        }
    }
    f64::midpoint(low, high)
}

/// Value of a prior that the part `u` lies below.
fn value(prior: Prior, u: f64) -> f64 {
    match prior {
        Prior::Uniform(a, b) => a + (b - a) * u,
        Prior::LogUniform(a, b) => a * libm::pow(b / a, u),
        Prior::Normal(mean, deviation) => mean + deviation * quantile(u),
        Prior::LogNormal(median, deviation) => median * libm::exp(deviation * quantile(u)),
        Prior::Known(value) => value,
    }
}

/// A prior times the likelihood of rows of its quantity.
#[derive(Clone, Debug)]
pub(super) struct Marginal {
    prior: Prior,
    /// Begin and width of a cell, and the part of the posterior up to each cell's begin; empty without rows.
    grid: (f64, f64, Vec<f64>),
    /// Logarithm of the rows' probability under the prior.
    pub(super) log_evidence: f64,
}

impl Marginal {
    /// A prior times the likelihood of rows; `None` where the prior has next to nothing near them.
    pub(super) fn new(prior: Prior, rows: &[&EvidenceRow]) -> Option<Self> {
        let likelihood = |u: f64| {
            rows.iter()
                .map(|row| log_likelihood(row, value(prior, u)))
                .sum::<f64>()
        };
        if let (Prior::Known(_), _) | (_, []) = (prior, rows) {
            let log_evidence = likelihood(0.5);
            return (log_evidence > NOWHERE).then_some(Self {
                prior,
                grid: (0.0, 1.0, Vec::new()),
                log_evidence,
            });
        }
        let (mut from, mut width) = (0.0, 1.0 / CELLS as f64);
        let mut heights = Vec::new();
        let mut most = f64::NEG_INFINITY;
        for _ in 0..ZOOMS {
            // The middle of a cell: a normal prior ends in no infinity.
            let middle = |cell: usize| likelihood(from + (cell as f64 + 0.5) * width);
            heights = (0..CELLS).map(middle).collect::<Vec<f64>>();
            most = heights.iter().copied().fold(f64::NEG_INFINITY, f64::max);
            let counts = |height: &f64| *height > most - NEGLIGIBLE;
            let first = heights.iter().position(counts).unwrap_or(0);
            let last = heights.iter().rposition(counts).unwrap_or(CELLS - 1);
            if last - first + 1 >= FINE || most.is_nan() {
                break;
            }
            let end = (from + (last as f64 + 2.0) * width).min(1.0);
            from = (from + (first as f64 - 1.0) * width).max(0.0);
            width = (end - from) / CELLS as f64;
        }
        if most.is_nan() || most < NOWHERE {
            return None;
        }
        let mut sum = 0.0;
        let mut below = vec![0.0];
        for height in &heights {
            sum += libm::exp(height - most);
            below.push(sum);
        }
        below.iter_mut().for_each(|part| *part /= sum);
        Some(Self {
            prior,
            grid: (from, width, below),
            log_evidence: most + libm::log(sum * width),
        })
    }

    /// The value that the part `u` of the posterior lies below; `u` in [0, 1).
    pub(super) fn value(&self, u: f64) -> f64 {
        let (from, width, below) = &self.grid;
        if below.is_empty() {
            // Neither end of a normal distribution.
            return value(self.prior, u.clamp(1e-15, 1.0 - 1e-15));
        }
        let cell = below.partition_point(|part| *part <= u).clamp(1, CELLS) - 1;
        let span = below[cell + 1] - below[cell];
        let inside = if span > 0.0 {
            (u - below[cell]) / span
        } else {
            0.5
        };
        value(self.prior, from + (cell as f64 + inside) * width)
    }
}

#[cfg(test)]
#[path = "marginal_tests.rs"]
mod tests;
