//! A protocol answered by simulated people, whose truth is known: how well it is found again.

use palpate_core::random::RandomStream;
use palpate_files::{Normal, Protocol, RatingTask, ThresholdTask};
use rayon::prelude::*;
use serde::Serialize;

use crate::compare::test;
use crate::psychometric::Psychometric;
use crate::threshold::{GUESS, LEAST_DB, Thresholding};

/// Studies of which the share that finds a difference is counted.
const STUDIES: u64 = 1000;
/// A study finds a difference where p is below this.
const LEVEL: f64 = 0.05;
/// The share of studies that shall find a difference that is there.
const POWER: f64 = 0.8;
/// Most people that are tried for it.
const MOST_PEOPLE: u32 = 1000;

/// What cannot be simulated.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum StudyError {
    /// Two groups of one person say nothing.
    #[error("--people: expected 4 at least for a rating that two groups give, found {0}")]
    FewPeople(u32),
}

/// Who answers.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Simulation {
    /// How many people.
    pub people: u32,
    /// All that is drawn follows from it.
    pub seed: u64,
}

/// How well thresholds came back.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Thresholds {
    /// Median over people and wires of the error, as a part of the true threshold's amplitude.
    pub threshold_error_median: f64,
    /// The share of 95 % intervals that hold the true threshold.
    pub coverage: f64,
    /// Median width of those intervals, dB.
    pub interval_db_median: f64,
    /// Thresholds that were estimated.
    pub thresholds: usize,
}

/// How often two groups are found to differ.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Ratings {
    /// The share of 1000 studies that find a difference where there is none.
    pub false_positive_rate: f64,
    /// The share that find the protocol's difference.
    pub power: f64,
    /// People of whom 80 % of studies find it; null where a thousand do not do.
    pub people_for_power: Option<u32>,
}

/// What a simulated study says about its protocol.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Outcome {
    /// Of the threshold task, where there is one.
    #[serde(flatten)]
    pub thresholds: Option<Thresholds>,
    /// Of the rating task, where there is one.
    #[serde(flatten)]
    pub ratings: Option<Ratings>,
}

/// Simulates a study. The same protocol, people and seed give the same outcome on any number of threads.
///
/// # Errors
/// [`StudyError`] for too few people.
pub fn simulate(protocol: &Protocol, of: Simulation) -> Result<Outcome, StudyError> {
    if protocol.rating.is_some() && of.people < 4 {
        return Err(StudyError::FewPeople(of.people));
    }
    let task = protocol.absolute_threshold.as_ref();
    Ok(Outcome {
        thresholds: task.map(|task| thresholds(task, of)),
        ratings: protocol.rating.as_ref().map(|task| ratings(task, of)),
    })
}

fn drawn(normal: Normal, random: &mut RandomStream) -> f64 {
    normal.mean + normal.sd * random.normal()
}

/// The true threshold of a participant's wire, dB, and the interval that the answers give.
fn found(task: &ThresholdTask, seed: u64, person: u32) -> Vec<(f64, crate::Estimate)> {
    let people = &task.simulated;
    let mut random = RandomStream::new(seed, &format!("participant {person}"));
    let own = drawn(people.threshold_db, &mut random);
    let felt = Psychometric {
        threshold: own,
        slope: drawn(people.slope, &mut random).max(0.5),
        guess: GUESS,
        lapse: people.lapse * random.uniform(),
    };
    let of_wire = |_: &u16| {
        let threshold = own + people.wire_sd_db * random.normal();
        let felt = Psychometric {
            // A level beyond what a wire can do has no threshold there to be found.
            threshold: threshold.clamp(LEAST_DB + 2.0, -2.0),
            ..felt
        };
        let mut session = Thresholding::new(task.method, task.trials);
        while let Some(level) = session.next() {
            session.answer(level, random.uniform() < felt.correct(level));
        }
        (felt.threshold, session.threshold())
    };
    task.wires.iter().map(of_wire).collect()
}

fn thresholds(task: &ThresholdTask, of: Simulation) -> Thresholds {
    let people = (1..=of.people).into_par_iter();
    let found: Vec<_> = people.flat_map_iter(|n| found(task, of.seed, n)).collect();
    let error = |true_db: f64, db: f64| (libm::pow(10.0, (db - true_db) / 20.0) - 1.0).abs();
    let held = |(t, e): &&(f64, crate::Estimate)| e.low <= *t && *t <= e.high;
    Thresholds {
        threshold_error_median: median(found.iter().map(|(t, e)| error(*t, e.value)).collect()),
        coverage: found.iter().filter(held).count() as f64 / found.len().max(1) as f64,
        interval_db_median: median(found.iter().map(|(_, e)| e.high - e.low).collect()),
        thresholds: found.len(),
    }
}

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    let (Some(low), Some(high)) = (
        values.get(values.len().saturating_sub(1) / 2),
        values.get(values.len() / 2),
    ) else {
        return 0.0;
    };
    (low + high) / 2.0
}

/// A participant's mean rating of a condition that is rated so much higher than the first.
fn mean_rating(task: &RatingTask, difference: f64, random: &mut RandomStream) -> f64 {
    let people = &task.simulated;
    let own = drawn(people.rating, random) + difference;
    let rating = |_| {
        let raw = own + people.noise * random.normal();
        libm::round(raw).clamp(1.0, 6.0)
    };
    (0..task.repeats).map(rating).sum::<f64>() / f64::from(task.repeats)
}

/// The share of studies with so many people that find a difference of this size.
fn share(task: &RatingTask, difference: f64, of: Simulation) -> f64 {
    let finds = |study: &u64| {
        let name = format!("study {study} of {} people, {difference}", of.people);
        let mut random = RandomStream::new(of.seed, &name);
        let mut group = |size: u32, difference: f64| -> Vec<f64> {
            (0..size)
                .map(|_| mean_rating(task, difference, &mut random))
                .collect()
        };
        let half = of.people / 2;
        let first = group(half, 0.0);
        let second = group(of.people - half, difference);
        test(&first, &second).is_some_and(|(_, p)| p < LEVEL)
    };
    (0..STUDIES).into_par_iter().filter(finds).count() as f64 / STUDIES as f64
}

fn ratings(task: &RatingTask, of: Simulation) -> Ratings {
    let difference = task.simulated.difference;
    let enough = |people| share(task, difference, Simulation { people, ..of }) >= POWER;
    Ratings {
        false_positive_rate: share(task, 0.0, of),
        power: share(task, difference, of),
        people_for_power: least(enough),
    }
}

/// The least number of people that is enough: doubled until it is, then halved in between.
fn least(enough: impl Fn(u32) -> bool) -> Option<u32> {
    let (mut few, mut many) = (2, 4);
    while !enough(many) {
        (few, many) = (many, many * 2);
        if many > MOST_PEOPLE {
            return None;
        }
    }
    while many - few > 1 {
        let middle = few.midpoint(many);
        match enough(middle) {
            true => many = middle,
            false => few = middle,
        }
    }
    Some(many)
}

#[cfg(test)]
#[path = "simulate_tests.rs"]
mod tests;
