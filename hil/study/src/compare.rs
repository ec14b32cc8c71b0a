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
mod tests {
    use super::*;

    /// Against `scipy.stats.mannwhitneyu(b, a, method="asymptotic")` of SciPy 1.17.1.
    #[test]
    fn it_agrees_with_scipy_with_ties() {
        let a = [1.0, 2.0, 2.0, 3.0, 4.0, 4.0, 5.0];
        let b = [2.0, 3.0, 4.0, 5.0, 5.0, 6.0, 6.0, 6.0];
        let (u, p) = test(&a, &b).unwrap();
        assert!((u - 44.5).abs() < 1e-12, "{u}");
        assert!((p - 0.06005331406956138).abs() < 1e-9, "{p}");
        let (_, other) = test(&b, &a).unwrap();
        assert!((other - p).abs() < 1e-12, "{other}");
    }

    /// Against `scipy.stats.mannwhitneyu(range(n), range(n, n + m), method="exact")` and `binomtest(n, n)`.
    #[test]
    fn few_people_cannot_differ_by_less_than_chance_allows() {
        for (sizes, p) in [
            ([1, 2], 2.0 / 3.0),
            ([2, 2], 1.0 / 3.0),
            ([3, 3], 0.1),
            ([4, 4], 1.0 / 35.0),
            ([5, 3], 1.0 / 28.0),
            ([0, 7], 1.0),
            ([1, 1], 1.0),
        ] {
            assert!((least_p(sizes) - p).abs() < 1e-12, "{sizes:?}");
        }
        assert!((0.0..1e-300).contains(&least_p([1000, 1000])));
        assert!((least_sign_p(5) - 0.0625).abs() < 1e-12);
        assert!((least_sign_p(0) - 1.0).abs() < 1e-12 && least_sign_p(6) < LEVEL);
        assert!(least_sign_p(u64::MAX) < 1e-300);
        let (_, p) = test(&[1.0, 2.0, 3.0], &[4.0, 5.0, 6.0]).unwrap();
        assert!((p - 0.1).abs() < 1e-12, "the approximation says 0.081: {p}");
    }

    #[test]
    fn equal_groups_do_not_differ_and_no_number_is_no_group() {
        let same = test(&[3.0; 5], &[3.0; 4]);
        assert_eq!(same.map(|(_, p)| p), Some(1.0));
        assert!(test(&[], &[1.0]).is_none());
        assert!(test(&[f64::NAN, 1.0], &[1.0]).is_none());
    }
}
