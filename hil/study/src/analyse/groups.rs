//! Statistics of groups: medians, intervals by bootstrap, and differences between two of them.

use palpate_core::random::RandomStream;
use palpate_core::statistics::{median, quantile};
use serde::Serialize;
use statrs::distribution::{Beta, Binomial, ContinuousCDF, DiscreteCDF};

use crate::compare::{LEVEL, least_p, test};
use crate::quest::Estimate;

/// Samples that are drawn anew for an interval.
const DRAWS: usize = 2000;

/// Two groups of people.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Comparison {
    /// Name of the compared value.
    pub of: String,
    /// The first condition.
    pub first: String,
    /// The second one.
    pub second: String,
    /// Values of the first, one per person, and of the second.
    pub counts: [usize; 2],
    /// Medians of both groups.
    pub medians: [f64; 2],
    /// Mann and Whitney's U of the second group.
    pub u: f64,
    /// Probability of a difference at least as large if there is none.
    pub p: f64,
    /// Least value that `p` can have with so many people.
    pub least_p: f64,
    /// Rank-biserial correlation, 2 U / (n m) - 1: 1 where all of the second are larger.
    pub effect: Estimate,
    /// Difference of the medians.
    pub difference: Estimate,
}

impl Comparison {
    /// Reason for which the comparison tells nothing, whatever was rated; `None` where there are people enough.
    #[must_use]
    pub fn says_nothing(&self) -> Option<String> {
        let [first, second] = self.counts;
        too_few(&format!("{first} against {second} people"), self.least_p)
    }
}

/// Reason for which so many people tell nothing; `None` where some outcome would.
pub(super) fn too_few(people: &str, least_p: f64) -> Option<String> {
    (least_p >= LEVEL).then(|| {
        format!("{people} say nothing: no answers of so few differ at p below {least_p:.2}")
    })
}

fn middle(values: &[f64]) -> f64 {
    median(values.iter().copied()).unwrap_or(f64::NAN)
}

fn drawn(values: &[f64], random: &mut RandomStream) -> Vec<f64> {
    let one = |_| values[((random.uniform() * values.len() as f64) as usize).min(values.len() - 1)];
    (0..values.len()).map(one).collect()
}

/// A figure of groups, and the middle 95 % of it over groups that are drawn anew from them, each by itself (percentile
/// bootstrap, Efron 1979). `None` for an empty group.
#[must_use]
fn bootstrap(groups: &[&[f64]], figure: impl Fn(&[Vec<f64>]) -> f64) -> Option<Estimate> {
    if groups.is_empty() || groups.iter().any(|group| group.is_empty()) {
        return None;
    }
    let own: Vec<Vec<f64>> = groups.iter().map(|group| group.to_vec()).collect();
    let mut random = RandomStream::new(1, "bootstrap");
    let mut figures: Vec<f64> = (0..DRAWS)
        .map(|_| {
            let anew: Vec<_> = groups
                .iter()
                .map(|group| drawn(group, &mut random))
                .collect();
            figure(&anew)
        })
        .collect();
    figures.sort_unstable_by(f64::total_cmp);
    Some(Estimate {
        value: figure(&own),
        low: quantile(&figures, 0.025)?.between(),
        high: quantile(&figures, 0.975)?.between(),
    })
}

/// A group's median with its interval. `None` for an empty group.
#[must_use]
pub fn median_within(values: &[f64]) -> Option<Estimate> {
    bootstrap(&[values], |anew| middle(&anew[0]))
}

/// The rank-biserial correlation of two groups, by counting pairs.
fn effect(first: &[f64], second: &[f64]) -> f64 {
    let pairs = first
        .iter()
        .flat_map(|a| second.iter().map(move |b| (a, b)));
    let over: f64 = pairs
        .map(|(a, b)| match b.total_cmp(a) {
            std::cmp::Ordering::Greater => 1.0,
            std::cmp::Ordering::Equal => 0.0,
            std::cmp::Ordering::Less => -1.0,
        })
        .sum();
    over / (first.len() * second.len()).max(1) as f64
}

/// Compares two groups, one value per person. `None` where one is empty.
#[must_use]
pub fn compared(
    of: &str,
    (first, second): (&str, &str),
    groups: [&[f64]; 2],
) -> Option<Comparison> {
    let (u, p) = test(groups[0], groups[1])?;
    Some(Comparison {
        of: of.into(),
        first: first.into(),
        second: second.into(),
        counts: groups.map(<[f64]>::len),
        medians: groups.map(middle),
        u,
        p,
        least_p: least_p(groups.map(<[f64]>::len)),
        effect: bootstrap(&groups, |anew| effect(&anew[0], &anew[1]))?,
        difference: bootstrap(&groups, |anew| middle(&anew[1]) - middle(&anew[0]))?,
    })
}

/// The part of answers that are yes, with its exact 95 % interval (Clopper and Pearson 1934).
#[must_use]
pub fn proportion(yes: u64, all: u64) -> Option<Estimate> {
    let (n, k) = (all as f64, yes as f64);
    let edge = |a: f64, b: f64, part: f64| Beta::new(a, b).ok().map(|beta| beta.inverse_cdf(part));
    (all > 0 && yes <= all).then_some(())?;
    Some(Estimate {
        value: k / n,
        low: if yes == 0 {
            0.0
        } else {
            edge(k, n - k + 1.0, 0.025)?
        },
        high: if yes == all {
            1.0
        } else {
            edge(k + 1.0, n - k, 0.975)?
        },
    })
}

/// Probability of so uneven a number of yes among `all` answers, or a more uneven one, where yes and no are as likely.
#[must_use]
pub fn sign_test(yes: u64, all: u64) -> f64 {
    let few = yes.min(all.saturating_sub(yes));
    match Binomial::new(0.5, all) {
        Ok(even) if all > 0 => (2.0 * even.cdf(few)).min(1.0),
        _ => 1.0,
    }
}

#[cfg(test)]
#[allow(clippy::float_cmp)] // these are exact
#[path = "groups_tests.rs"]
mod tests;
