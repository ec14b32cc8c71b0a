//! Ratings in figures: boxes, and the Mann-Whitney U test as scipy computes it.

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
    /// Of some ratings; `None` of none.
    pub fn of(ratings: &[u8]) -> Option<Self> {
        let mut sorted = ratings.to_vec();
        sorted.sort_unstable();
        let last = sorted.len().checked_sub(1)?;
        let quantile = |part: f64| {
            let at = part * last as f64;
            let (low, high) = (sorted[at.floor() as usize], sorted[at.ceil() as usize]);
            f64::from(low) + (at - at.floor()) * (f64::from(high) - f64::from(low))
        };
        let (q1, q3) = (quantile(0.25), quantile(0.75));
        let reach = 1.5 * (q3 - q1);
        let within = |r: &u8| (q1 - reach..=q3 + reach).contains(&f64::from(*r));
        let inside: Vec<u8> = sorted.iter().copied().filter(within).collect();
        Some(Self {
            low: inside.first().map_or(q1, |r| f64::from(*r).min(q1)),
            q1,
            median: quantile(0.5),
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
mod tests {
    use super::*;
    use serde_json::Value;

    /// What scipy says of samples with many ties, few, all alike, of unequal size: `ci/peers/panel.py oracle`.
    #[test]
    fn mann_whitney_is_scipys() {
        let oracle: Vec<Value> = serde_json::from_str(include_str!("oracle.json")).unwrap();
        assert!(oracle.len() > 50);
        for case in &oracle {
            let sample = |key: &str| -> Vec<u8> {
                let all = case[key].as_array().unwrap().iter();
                all.map(|v| v.as_u64().unwrap() as u8).collect()
            };
            let (u, p) = mann_whitney(&sample("a"), &sample("b")).unwrap();
            let off = |found: f64, key: &str| (found - case[key].as_f64().unwrap()).abs();
            assert!(off(u, "u") < 1e-9 && off(p, "p") < 1e-9, "{u} {p} {case}");
        }
        assert_eq!(mann_whitney(&[], &[1]), None);
    }

    #[test]
    fn boxes_have_linear_quartiles_and_outliers() {
        let found = Box5::of(&[3, 3, 4, 4, 4, 5, 6, 1, 4, 4, 3, 4]).unwrap();
        let expected = Box5 {
            low: 3.0,
            q1: 3.0,
            median: 4.0,
            q3: 4.0,
            high: 5.0,
            outliers: vec![1, 6],
        };
        assert_eq!(found, expected);
        let even = Box5::of(&[1, 2, 3, 4]).unwrap();
        assert_eq!((even.q1, even.median, even.q3), (1.75, 2.5, 3.25));
        assert_eq!(Box5::of(&[]), None);
    }
}
