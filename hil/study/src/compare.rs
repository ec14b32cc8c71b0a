//! Whether two groups of people rated differently.

use statrs::stats_tests::Alternative;
use statrs::stats_tests::mannwhitneyu::{MannWhitneyUMethod, mannwhitneyu};

/// Mann and Whitney's U of the second group, and the probability of a difference at least as large if there is none:
/// two-sided, by the normal approximation with ties and continuity. One value per person. `None` where a group is empty or
/// a value is not a number; where all values are equal there is no difference.
pub(crate) fn test(first: &[f64], second: &[f64]) -> Option<(f64, f64)> {
    let method = MannWhitneyUMethod::AsymptoticInclContinuityCorrection;
    let (u, p) = mannwhitneyu(second, first, method, Alternative::TwoSided).ok()?;
    let p = if p.is_nan() { 1.0 } else { p.min(1.0) };
    Some((u, p))
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

    #[test]
    fn equal_groups_do_not_differ_and_no_number_is_no_group() {
        let same = test(&[3.0; 5], &[3.0; 4]);
        assert_eq!(same.map(|(_, p)| p), Some(1.0));
        assert!(test(&[], &[1.0]).is_none());
        assert!(test(&[f64::NAN, 1.0], &[1.0]).is_none());
    }
}
