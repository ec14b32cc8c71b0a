//! QUEST+: the level of the next trial is the one whose answer tells most.

use serde::Serialize;

use crate::psychometric::Psychometric;

/// Levels, thresholds and slopes of QUEST+, each in rising order, and its fixed parameters.
#[derive(Debug, Clone, PartialEq)]
pub struct QuestDomain {
    /// Levels of a stimulus, dB.
    pub levels: Vec<f64>,
    /// Thresholds, dB.
    pub thresholds: Vec<f64>,
    /// Slopes, as [`Psychometric::slope`].
    pub slopes: Vec<f64>,
    /// Probability of a correct answer without a stimulus.
    pub guess: f64,
    /// Probability of a slip.
    pub lapse: f64,
    /// The part of the way from guessing to certainty that is gone at a threshold: 1 - 1/e is that of
    /// [`Psychometric::threshold`].
    pub part: f64,
}

/// A number with its 95 % interval.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Estimate {
    /// The number; for a threshold the mean of the posterior.
    pub value: f64,
    /// 2.5 % of the posterior, or of samples drawn anew, lie below.
    pub low: f64,
    /// 2.5 % of the posterior, or of samples drawn anew, lie above.
    pub high: f64,
}

/// Bayesian adaptive estimation of a psychometric function (Watson 2017, "QUEST+: A general multidimensional Bayesian
/// adaptive psychometric method", Journal of Vision 17(3):10), with a flat prior.
#[derive(Debug, Clone)]
pub struct Quest {
    domain: QuestDomain,
    /// Probability of a correct answer and negative entropy of the answer, nats, by level and by threshold with slope.
    likelihoods: Vec<Vec<(f64, f64)>>,
    /// Posterior probability of each threshold with each slope; sums to one.
    posterior: Vec<f64>,
}

/// `p ln p`, 0 where p is 0.
fn times_log(p: f64) -> f64 {
    if p > 0.0 { p * libm::log(p) } else { 0.0 }
}

/// Distance above [`Psychometric::threshold`] at which the part `part` of the way from guessing to certainty is gone,
/// dB.
fn way(part: f64, slope: f64) -> f64 {
    20.0 / slope * libm::log10(-libm::log(1.0 - part))
}

impl Quest {
    /// A method that knows nothing yet, over a domain none of whose lists is empty.
    pub fn new(domain: QuestDomain) -> Self {
        let count = domain.thresholds.len() * domain.slopes.len();
        let (guess, lapse, part) = (domain.guess, domain.lapse, domain.part);
        let of = |level: f64| -> Vec<(f64, f64)> {
            let possible = domain.thresholds.iter().flat_map(|threshold| {
                domain.slopes.iter().map(move |slope| Psychometric {
                    threshold: threshold - way(part, *slope),
                    slope: *slope,
                    guess,
                    lapse,
                })
            });
            let likelihood = |felt: Psychometric| {
                let correct = felt.correct(level);
                (correct, times_log(correct) + times_log(1.0 - correct))
            };
            possible.map(likelihood).collect()
        };
        Self {
            likelihoods: domain.levels.iter().map(|level| of(*level)).collect(),
            posterior: vec![1.0 / count as f64; count],
            domain,
        }
    }

    /// Expected entropy of the posterior after a trial at this level, nats, up to a constant of all levels: the entropy
    /// of the answer given the truth, less that of the answer.
    fn expected_entropy(&self, likelihoods: &[(f64, f64)]) -> f64 {
        let (mut correct, mut known) = (0.0, 0.0);
        for (held, (likely, answer)) in self.posterior.iter().zip(likelihoods) {
            correct += held * likely;
            known += held * answer;
        }
        times_log(correct) + times_log(1.0 - correct) - known
    }

    /// The largest level that it may ask for, dB.
    pub(crate) fn most(&self) -> f64 {
        self.domain.levels.last().copied().unwrap_or_default()
    }

    /// The level of the next trial, dB: the first that leaves the least entropy.
    pub fn next(&self) -> f64 {
        let mut best = (f64::INFINITY, 0);
        for (index, likelihoods) in self.likelihoods.iter().enumerate() {
            let entropy = self.expected_entropy(likelihoods);
            if entropy < best.0 {
                best = (entropy, index);
            }
        }
        self.domain.levels[best.1]
    }

    /// Takes an answer at a level in; a level outside the domain counts as the nearest one there.
    pub fn answer(&mut self, level: f64, correct: bool) {
        let away = |index: &usize| libm::fabs(self.domain.levels[*index] - level);
        let indices = 0..self.domain.levels.len();
        let Some(nearest) = indices.min_by(|a, b| away(a).total_cmp(&away(b))) else {
            return;
        };
        let mut sum = 0.0;
        for (held, (likely, _)) in self.posterior.iter_mut().zip(&self.likelihoods[nearest]) {
            *held *= if correct { *likely } else { 1.0 - likely };
            sum += *held;
        }
        if sum > 0.0 {
            self.posterior.iter_mut().for_each(|held| *held /= sum);
        }
    }

    /// The threshold, dB, with its interval: between two thresholds of the domain the posterior is taken to be spread
    /// evenly.
    pub fn threshold(&self) -> Estimate {
        let slopes = self.domain.slopes.len();
        let marginal: Vec<f64> = self
            .posterior
            .chunks(slopes)
            .map(|of_one| of_one.iter().sum())
            .collect();
        let thresholds = &self.domain.thresholds;
        let value = thresholds.iter().zip(&marginal).map(|(t, p)| t * p).sum();
        Estimate {
            value,
            low: quantile(thresholds, &marginal, 0.025),
            high: quantile(thresholds, &marginal, 0.975),
        }
    }
}

/// Quantile `part` of a distribution over places; each place stands for itself and half the way to its neighbours.
fn quantile(places: &[f64], held: &[f64], part: f64) -> f64 {
    let last = places.len() - 1;
    let mut below = 0.0;
    for (index, (place, held)) in places.iter().zip(held).enumerate() {
        if below + held >= part || index == last {
            let from = place - (place - places[index.saturating_sub(1)]) / 2.0;
            let to = place + (places[(index + 1).min(last)] - place) / 2.0;
            let way = if *held > 0.0 {
                (part - below) / held
            } else {
                0.0
            };
            return from + (to - from) * way.clamp(0.0, 1.0);
        }
        below += held;
    }
    places[last]
}

#[cfg(test)]
#[path = "quest_tests.rs"]
mod tests;
