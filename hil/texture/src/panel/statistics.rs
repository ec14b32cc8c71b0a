//! Ratings in figures: boxes, and the Mann-Whitney U test as scipy computes it.

use palpate_core::statistics::{Quantile, quantile};
use serde::Serialize;
use statrs::stats_tests::Alternative;
use statrs::stats_tests::mannwhitneyu::{MannWhitneyUMethod, mannwhitneyu};

/// A box plot's figures: quartiles between neighbours linearly, whiskers to the last rating within one and a half boxes.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Box5 {
    /// Lower whisker.
    pub low: f64,
    /// First quartile.
    pub q1: f64,
    /// Median.
    pub median: f64,
    /// Third quartile.
    pub q3: f64,
    /// Upper whisker.
    pub high: f64,
    /// Ratings beyond the whiskers, ascending.
    pub outliers: Vec<u8>,
}

impl Box5 {
    /// Box of some ratings; `None` for none.
    pub fn new(ratings: &[u8]) -> Option<Self> {
        let mut sorted = ratings.to_vec();
        sorted.sort_unstable();
        let at = |part| quantile(&sorted, part).map(Quantile::between);
        let (q1, median, q3) = (at(0.25)?, at(0.5)?, at(0.75)?);
        let reach = 1.5 * (q3 - q1);
        let within = |r: &u8| (q1 - reach..=q3 + reach).contains(&f64::from(*r));
        let inside: Vec<u8> = sorted.iter().copied().filter(within).collect();
        Some(Self {
            low: inside.first().map_or(q1, |r| f64::from(*r).min(q1)),
            q1,
            median,
            q3,
            high: inside.last().map_or(q3, |r| f64::from(*r).max(q3)),
            outliers: sorted.into_iter().filter(|r| !within(r)).collect(),
        })
    }
}

/// U of the first sample and the two-sided p: the normal approximation with ties and continuity, which is
/// `scipy.stats.mannwhitneyu(a, b, method="asymptotic")`. Ratings have ties, for which the exact one is not defined.
/// `None` where a sample is empty.
pub fn mann_whitney(a: &[u8], b: &[u8]) -> Option<(f64, f64)> {
    let method = MannWhitneyUMethod::AsymptoticInclContinuityCorrection;
    mannwhitneyu(a, b, method, Alternative::TwoSided).ok()
}

#[cfg(test)]
#[path = "statistics_tests.rs"]
mod tests;
