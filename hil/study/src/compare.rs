//! Tests of whether two groups of people rated differently.

use statrs::stats_tests::Alternative;
use statrs::stats_tests::mannwhitneyu::{MannWhitneyUMethod, mannwhitneyu};

/// Probability by chance below which a difference counts as found.
pub(crate) const LEVEL: f64 = 0.05;

/// Mann and Whitney's U of the second group, and the probability of a difference at least as large if there is none:
/// two-sided, by the normal approximation with ties and continuity, and never below the least that so few people can
/// have. One value per person. `None` where a group is empty or a value is not a number; where all values are equal
/// there is no difference.
pub(crate) fn test(first: &[f64], second: &[f64]) -> Option<(f64, f64)> {
    let method = MannWhitneyUMethod::AsymptoticInclContinuityCorrection;
    let (u, p) = mannwhitneyu(second, first, method, Alternative::TwoSided).ok()?;
    let p = if p.is_nan() { 1.0 } else { p.min(1.0) };
    Some((u, p.max(least_p([first.len(), second.len()]))))
}

/// The least probability that any outcome of two groups of so many people has: that of all of one group above all of the
/// other, either way.
pub(crate) fn least_p([first, second]: [usize; 2]) -> f64 {
    let (few, many) = (first.min(second), first.max(second));
    // One over the ways to choose the smaller group, factor by factor.
    let one = |n: usize| n as f64 / (many + n) as f64;
    let ways: f64 = (1..=few).map(one).product();
    (2.0 * ways).min(1.0)
}

/// The least probability that any preference of so many people has: all of them for one of two.
pub(crate) fn least_sign_p(people: u64) -> f64 {
    let more = i32::try_from(people.saturating_sub(1)).unwrap_or(i32::MAX);
    libm::pow(0.5, f64::from(more)).min(1.0)
}

#[cfg(test)]
#[path = "compare_tests.rs"]
mod tests;
