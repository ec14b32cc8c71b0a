//! A protocol answered by simulated people, whose truth is known: the errors of its estimates, and the number of people
//! that a difference needs.

use std::collections::BTreeMap;

use palpate_core::random::RandomStream;
use palpate_core::statistics::{mean, median};
use palpate_files::{ChoiceTask, Protocol, RatingTask, TaskKind};
use rayon::prelude::*;
use serde::Serialize;

use crate::analyse::{compare_paths, sign_test};
use crate::compare::{LEVEL, test};
use crate::people::{Known, Person, drawn};
use crate::quest::Estimate;
use crate::session::{Answer, Reply, Session, Step, Stimulus};

/// Studies of which the share with an effect is counted.
const STUDIES: u64 = 1000;
/// Share of studies that shall find a true difference.
const POWER: f64 = 0.8;
/// Most people for whom that share is tried.
const MOST_PEOPLE: u32 = 1000;

/// Errors of a simulation.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum StudyError {
    /// A study of two groups needs two people in each.
    #[error("--people: expected 4 at least for a rating that two groups give, found {0}")]
    FewPeople(u32),
}

/// People and seed of a simulation.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Simulation {
    /// Number of people.
    pub people: u32,
    /// Seed of everything that is drawn.
    pub seed: u64,
}

/// Recovery of thresholds: the estimates against the truth.
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

/// Recovery of other levels: the estimates against the truth.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Levels {
    /// Median error, dB.
    pub error_db_median: f64,
    /// The share of 95 % intervals that hold the truth.
    pub coverage: f64,
    /// Median width of those intervals, dB.
    pub interval_db_median: f64,
    /// Levels that were estimated.
    pub levels: usize,
}

/// Accuracy of the places that people pointed at.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Places {
    /// Share of answers that are nearest to the driven wire.
    pub correct: f64,
    /// Median distance from the driven wire, mm.
    pub error_mm_median: f64,
}

/// Accuracy of drawings.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Drawings {
    /// Median over drawings of the error after alignment, mm.
    pub rmse_mm_median: f64,
    /// Median discrete Frechet distance, mm.
    pub frechet_mm_median: f64,
    /// Mean of breaks per drawing.
    pub breaks_mean: f64,
}

/// Share of studies that find an effect, p below 5 %.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Detection {
    /// The share of 1000 studies that find an effect where there is none.
    pub false_positive_rate: f64,
    /// Share of studies that find the protocol's effect.
    pub power: f64,
    /// People with whom 80 % of studies find the effect; null where a thousand are too few.
    pub people_for_power: Option<u32>,
}

/// Outcome of a simulated study, for its protocol.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Outcome {
    /// Result of the threshold task, where there is one.
    #[serde(flatten)]
    pub thresholds: Option<Thresholds>,
    /// Result of the rating task: a difference between two groups of people, who met two conditions or gave two studies of the same
    /// one.
    #[serde(flatten)]
    pub ratings: Option<Detection>,
    /// Result of the difference task, in parts of the amplitude.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub difference: Option<Levels>,
    /// Result of the matching task.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub matching: Option<Levels>,
    /// Result of the localisation task.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub localisation: Option<Places>,
    /// Result of the drawing task.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub drawing: Option<Drawings>,
    /// Result of the choice task: a preference for one of two, by the sign test over people.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub choice: Option<Detection>,
}

/// Results of one person's session, beside their truth.
#[derive(Debug, Default)]
struct Answered {
    /// True level and estimate, by task.
    levels: BTreeMap<TaskKind, Vec<(f64, Estimate)>>,
    /// `true` where the nearest wire was the driven one, with the distance from the driven wire, mm.
    places: Vec<(bool, f64)>,
    /// Error and Frechet distance, mm, and breaks.
    drawings: Vec<(f64, f64, usize)>,
}

/// Simulates a study: every person goes through a session of their own. The same protocol, people and seed give the same
/// outcome on any number of threads.
///
/// # Errors
/// [`StudyError`] for too few people.
pub fn simulate(protocol: &Protocol, of: Simulation, known: &Known) -> Result<Outcome, StudyError> {
    if protocol.rating.is_some() && of.people < 4 {
        return Err(StudyError::FewPeople(of.people));
    }
    let people = (1..=of.people).into_par_iter();
    let people: Vec<Answered> = people
        .map(|number| answered(protocol, number, of.seed, known))
        .collect();
    let all = |task: TaskKind| -> Vec<(f64, Estimate)> {
        let each = people.iter().filter_map(|person| person.levels.get(&task));
        each.flatten().copied().collect()
    };
    let places: Vec<_> = people.iter().flat_map(|p| &p.places).copied().collect();
    let drawings: Vec<_> = people.iter().flat_map(|p| &p.drawings).copied().collect();
    Ok(Outcome {
        thresholds: thresholds(&all(TaskKind::AbsoluteThreshold)),
        ratings: protocol.rating.as_ref().map(|task| {
            let size = task.simulated.difference;
            detection(size, of, |size, of| differ(task, size, of))
        }),
        difference: levels(&all(TaskKind::Difference)),
        matching: levels(&all(TaskKind::Matching)),
        localisation: localisation(&places),
        drawing: drawing(&drawings),
        choice: protocol.choice.as_ref().map(|task| {
            let size = task.simulated.preference.mean;
            detection(size, of, |size, of| prefer(task, size, of))
        }),
    })
}

fn localisation(places: &[(bool, f64)]) -> Option<Places> {
    Some(Places {
        correct: mean(places.iter().map(|(right, _)| f64::from(u8::from(*right))))?,
        error_mm_median: median(places.iter().map(|(_, mm)| *mm))?,
    })
}

fn drawing(drawings: &[(f64, f64, usize)]) -> Option<Drawings> {
    Some(Drawings {
        rmse_mm_median: median(drawings.iter().map(|d| d.0))?,
        frechet_mm_median: median(drawings.iter().map(|d| d.1))?,
        breaks_mean: mean(drawings.iter().map(|d| d.2 as f64))?,
    })
}

/// A person's session from beginning to end.
fn answered(protocol: &Protocol, number: u32, seed: u64, known: &Known) -> Answered {
    let person = Person::new(protocol, number, seed, known);
    let mut session = Session::new(protocol.clone(), number, seed);
    let mut answered = Answered::default();
    while let Some(reply) = person.reply(protocol, session.step(), known) {
        if let (Step::Trial(trial), Reply::Answer(answer)) = (session.step(), &reply)
            && !trial.practice
        {
            match (answer, trial.intervals.first()) {
                (Answer::Place(place), Some(Stimulus::Wire { wire, .. })) => {
                    answered
                        .places
                        .extend(pointed(known, usize::from(*wire), *place));
                }
                (Answer::Path(strokes), Some(Stimulus::Condition(name))) => {
                    let path = known.paths.get(name).map_or(&[][..], |path| path);
                    let error = compare_paths(path, strokes);
                    answered
                        .drawings
                        .extend(error.map(|e| (e.rmse_mm, e.frechet_mm, e.breaks)));
                }
                _ => {}
            }
        }
        // A reply that the person made to this very step.
        if session.take(&reply).is_err() {
            break;
        }
    }
    for (task, felt) in &person.felt {
        let truth = felt.iter().map(|felt| match task {
            // The level at which a wire is called stronger as often as weaker.
            TaskKind::Matching => felt.threshold + felt.halfway(),
            _ => felt.threshold,
        });
        let found = session.estimates(*task).into_iter();
        let beside = truth.zip(found.map(|(_, estimate)| estimate)).collect();
        answered.levels.insert(*task, beside);
    }
    answered
}

/// Tells whether `wire` is nearest to a place, with its distance, mm.
fn pointed(known: &Known, wire: usize, [x, y]: [f64; 2]) -> Option<(bool, f64)> {
    let away = |at: &[f64; 2]| libm::hypot(at[0] - x, at[1] - y);
    let own = away(known.wires_mm.get(wire)?);
    Some((known.wires_mm.iter().all(|other| own <= away(other)), own))
}

fn held(found: &[(f64, Estimate)]) -> f64 {
    let holds = |(t, e): &&(f64, Estimate)| e.low <= *t && *t <= e.high;
    found.iter().filter(holds).count() as f64 / found.len().max(1) as f64
}

fn widths(found: &[(f64, Estimate)]) -> Option<f64> {
    median(found.iter().map(|(_, e)| e.high - e.low))
}

fn thresholds(found: &[(f64, Estimate)]) -> Option<Thresholds> {
    let error =
        |(true_db, e): &(f64, Estimate)| (libm::pow(10.0, (e.value - true_db) / 20.0) - 1.0).abs();
    Some(Thresholds {
        threshold_error_median: median(found.iter().map(error))?,
        coverage: held(found),
        interval_db_median: widths(found)?,
        thresholds: found.len(),
    })
}

fn levels(found: &[(f64, Estimate)]) -> Option<Levels> {
    let error = |(true_db, e): &(f64, Estimate)| (e.value - true_db).abs();
    Some(Levels {
        error_db_median: median(found.iter().map(error))?,
        coverage: held(found),
        interval_db_median: widths(found)?,
        levels: found.len(),
    })
}

/// A participant's mean rating of a condition that is rated `difference` higher than the first.
fn mean_rating(task: &RatingTask, difference: f64, random: &mut RandomStream) -> f64 {
    let people = &task.simulated;
    let own = drawn(people.rating, random) + difference;
    let rating = |_| {
        let raw = own + people.noise * random.normal();
        libm::round(raw).clamp(1.0, 6.0)
    };
    (0..task.repeats).map(rating).sum::<f64>() / f64::from(task.repeats)
}

/// The share of studies that find an effect of this size, each with draws of its own.
fn share(
    word: &str,
    size: f64,
    of: Simulation,
    finds: impl Fn(&mut RandomStream) -> bool + Sync,
) -> f64 {
    let found = |study: &u64| {
        let name = format!("{word} {study} of {} people, {size}", of.people);
        finds(&mut RandomStream::new(of.seed, &name))
    };
    (0..STUDIES).into_par_iter().filter(found).count() as f64 / STUDIES as f64
}

/// Detection of an effect of this size. `share` gives the share of studies with so many people that find one.
fn detection(size: f64, of: Simulation, share: impl Fn(f64, Simulation) -> f64) -> Detection {
    Detection {
        false_positive_rate: share(0.0, of),
        power: share(size, of),
        people_for_power: least(|people| share(size, Simulation { people, ..of }) >= POWER),
    }
}

/// The share of studies with so many people that find a difference of this size.
fn differ(task: &RatingTask, difference: f64, of: Simulation) -> f64 {
    share("study", difference, of, |random| {
        let mut group = |size: u32, difference: f64| -> Vec<f64> {
            (0..size)
                .map(|_| mean_rating(task, difference, random))
                .collect()
        };
        let half = of.people / 2;
        let first = group(half, 0.0);
        let second = group(of.people - half, difference);
        test(&first, &second).is_some_and(|(_, p)| p < LEVEL)
    })
}

/// The share of studies with so many people that find a preference of this mean, by the sign test over people.
fn prefer(task: &ChoiceTask, mean: f64, of: Simulation) -> f64 {
    share("choices", mean, of, |random| {
        let (mut second, mut first) = (0, 0);
        for _ in 0..of.people {
            let logit = mean + task.simulated.preference.sd * random.normal();
            let part = 1.0 / (1.0 + libm::exp(-logit));
            let yes = (0..task.repeats)
                .filter(|_| random.uniform() < part)
                .count() as u32;
            match (2 * yes).cmp(&task.repeats) {
                std::cmp::Ordering::Greater => second += 1,
                std::cmp::Ordering::Less => first += 1,
                std::cmp::Ordering::Equal => {}
            }
        }
        sign_test(second, second + first) < LEVEL
    })
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
