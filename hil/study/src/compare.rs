//! Whether two groups of people rated differently.

use palpate_core::random::RandomStream;
use statrs::stats_tests::Alternative;
use statrs::stats_tests::mannwhitneyu::{MannWhitneyUMethod, mannwhitneyu};

/// So many times both groups are drawn anew for an interval.
const DRAWS: usize = 1000;

/// Two groups beside each other.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Comparison {
    /// Mann and Whitney's U of the second group.
    pub u: f64,
    /// Probability of a difference at least as large if there is none: two-sided, by the normal approximation with ties and
    /// continuity.
    pub p: f64,
    /// How often one of the second group is above one of the first, less how often it is below: -1 to 1 (Cliff 1993).
    pub effect: f64,
    /// The effect's 95 % interval, by bootstrap (Efron 1979; percentiles of 1000 draws).
    pub interval: (f64, f64),
}

/// Cliff's delta.
fn effect(first: &[f64], second: &[f64]) -> f64 {
    let pairs = first
        .iter()
        .flat_map(|a| second.iter().map(move |b| (*a, *b)));
    let above = pairs.map(|(a, b)| f64::from(i8::from(b > a) - i8::from(b < a)));
    above.sum::<f64>() / (first.len() * second.len()) as f64
}

/// One value per person, two groups. `None` where a group is empty or a value is not a number.
pub fn compare(first: &[f64], second: &[f64], seed: u64) -> Option<Comparison> {
    let (u, p) = test(first, second)?;
    let mut random = RandomStream::new(seed, "bootstrap");
    let mut again = |group: &[f64]| -> Vec<f64> {
        let one = |_| group[(random.uniform() * group.len() as f64) as usize];
        (0..group.len()).map(one).collect()
    };
    let mut effects: Vec<f64> = (0..DRAWS)
        .map(|_| {
            let first = again(first);
            effect(&first, &again(second))
        })
        .collect();
    effects.sort_by(f64::total_cmp);
    Some(Comparison {
        u,
        p,
        effect: effect(first, second),
        interval: (effects[DRAWS / 40], effects[DRAWS - 1 - DRAWS / 40]),
    })
}

/// U of the second group and p. Where all values are equal there is no difference.
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
        let found = compare(&a, &b, 1).unwrap();
        assert!((found.u - 44.5).abs() < 1e-12, "{found:?}");
        assert!((found.p - 0.06005331406956138).abs() < 1e-9, "{found:?}");
        // U = (effect + 1) / 2 of all pairs.
        assert!((found.u - (found.effect + 1.0) / 2.0 * 56.0).abs() < 1e-9);
        assert!(found.interval.0 < found.effect && found.effect < found.interval.1);
        let other = compare(&b, &a, 1).unwrap();
        assert!((other.effect + found.effect).abs() < 1e-12, "{other:?}");
        assert!((other.p - found.p).abs() < 1e-12);
    }

    #[test]
    fn equal_groups_do_not_differ_and_no_number_is_no_group() {
        let same = compare(&[3.0; 5], &[3.0; 4], 1).unwrap();
        assert_eq!((same.p, same.effect), (1.0, 0.0));
        assert!(compare(&[], &[1.0], 1).is_none());
        assert!(compare(&[f64::NAN, 1.0], &[1.0], 1).is_none());
    }
}
