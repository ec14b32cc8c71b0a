//! Percentiles of drawn figures, before and after their weights.

use palpate_files::Quantity;
use serde::Serialize;

use super::draw::Draw;

/// Figures of a draw.
#[derive(Clone, Debug, PartialEq)]
pub struct Drawn {
    /// Wires, finger and person.
    pub draw: Draw,
    /// Logarithm of the weight of each row.
    pub log_weights: Vec<f64>,
    /// Level over the person's threshold, dB.
    pub level_db: f64,
    /// Larger error of the felt place by both centroids over all onsets, RMSE, mm.
    pub error_mm: f64,
}

/// Figures at 5, 50 and 95 %, and the share that is felt.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Spread {
    /// Level over the person's threshold, dB.
    pub level_db: [f64; 3],
    /// Share of draws whose person feels half of the onsets or more.
    pub felt: f64,
    /// Error of the felt place over all onsets, RMSE, mm.
    pub error_mm: [f64; 3],
}

/// Probabilities of kinds of wire.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Kinds {
    /// Taut wires.
    pub taut: f64,
    /// Loose ones by their two-way strain: below 0.3 %, to 1 %, above.
    pub loose: [f64; 3],
}

/// Result of all draws.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Posterior {
    /// Number of draws.
    pub draws: usize,
    /// Effective sample size of the weights.
    pub effective: f64,
    /// Effective sample size of each weighed row alone.
    pub effective_of_rows: Vec<f64>,
    /// Figures before published strokes and levels count.
    pub before: Spread,
    /// Figures by all evidence.
    pub after: Spread,
    /// Wires before published strokes and levels count.
    pub kinds_before: Kinds,
    /// Wires by all evidence.
    pub kinds_after: Kinds,
}

/// Weights from their logarithms, the largest 1.
fn weights(logs: impl Iterator<Item = f64> + Clone) -> Vec<f64> {
    let most = logs.clone().fold(f64::NEG_INFINITY, f64::max);
    logs.map(|log| {
        if most.is_finite() {
            libm::exp(log - most)
        } else {
            0.0
        }
    })
    .collect()
}

/// Effective sample size: the squared sum of weights over the sum of squares.
fn effective(weights: &[f64]) -> f64 {
    let (sum, squares) = weights
        .iter()
        .fold((0.0, 0.0), |(s, q), w| (s + w, q + w * w));
    if squares > 0.0 {
        sum * sum / squares
    } else {
        0.0
    }
}

/// Values that 5, 50 and 95 % of the weights lie below.
pub fn percentiles(values: impl Iterator<Item = f64>, weights: &[f64]) -> [f64; 3] {
    let mut pairs: Vec<(f64, f64)> = values.zip(weights.iter().copied()).collect();
    pairs.sort_by(|a, b| a.0.total_cmp(&b.0));
    let total: f64 = pairs.iter().map(|pair| pair.1).sum();
    [0.05, 0.5, 0.95].map(|part| {
        let mut below = 0.0;
        let found = pairs.iter().find(|pair| {
            below += pair.1;
            below >= part * total
        });
        found.or(pairs.last()).map_or(0.0, |pair| pair.0)
    })
}

impl Posterior {
    /// Percentiles of draws.
    pub fn new(drawn: &[Drawn]) -> Self {
        let own = weights(drawn.iter().map(|d| d.draw.log_weight));
        let all = |d: &Drawn| d.draw.log_weight + d.log_weights.iter().sum::<f64>();
        let after = weights(drawn.iter().map(all));
        let rows = drawn.first().map_or(0, |d| d.log_weights.len());
        let of_row = |row: usize| {
            let logs = drawn
                .iter()
                .map(|d| d.log_weights.get(row).copied().unwrap_or(0.0));
            effective(&weights(logs))
        };
        Self {
            draws: drawn.len(),
            effective: effective(&after),
            effective_of_rows: (0..rows).map(of_row).collect(),
            before: spread(drawn, &own),
            after: spread(drawn, &after),
            kinds_before: kinds(drawn, &own),
            kinds_after: kinds(drawn, &after),
        }
    }
}

/// Share of the weights of draws for which something holds.
fn share(drawn: &[Drawn], weights: &[f64], holds: impl Fn(&Drawn) -> bool) -> f64 {
    let (mut of, mut all) = (0.0, 0.0);
    for (d, w) in drawn.iter().zip(weights) {
        all += w;
        of += if holds(d) { *w } else { 0.0 };
    }
    if all > 0.0 { of / all } else { 0.0 }
}

fn spread(drawn: &[Drawn], weights: &[f64]) -> Spread {
    Spread {
        level_db: percentiles(drawn.iter().map(|d| d.level_db), weights),
        felt: share(drawn, weights, |d| d.level_db >= 0.0),
        error_mm: percentiles(drawn.iter().map(|d| d.error_mm), weights),
    }
}

fn kinds(drawn: &[Drawn], weights: &[f64]) -> Kinds {
    let strain = |d: &Drawn| d.draw.value(Quantity::Strain).unwrap_or(0.0);
    let loose = |from: f64, to: f64| {
        share(drawn, weights, |d| {
            !d.draw.is_taut && (from..to).contains(&strain(d))
        })
    };
    Kinds {
        taut: share(drawn, weights, |d| d.draw.is_taut),
        loose: [loose(0.0, 0.3), loose(0.3, 1.0), loose(1.0, f64::INFINITY)],
    }
}

#[cfg(test)]
#[path = "posterior_tests.rs"]
mod tests;
