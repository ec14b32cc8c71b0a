//! Analysis of a study's answers: a pure function of its records.

mod groups;
mod paths;
mod tables;

use std::collections::BTreeMap;

use palpate_core::statistics::{mean, median};
use palpate_files::{Protocol, TaskKind};
use serde::Serialize;

pub use groups::{Comparison, compared, median_within, proportion, sign_test};
pub use paths::{PathError, compare_paths};
pub use tables::{AnalysisTable, tables};

use crate::compare::least_sign_p;
use crate::psychometric::Psychometric;
use crate::quest::Estimate;
use crate::record::{Record, RecordError};
use crate::session::Answer;

/// Results of a study's records.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Analysis {
    /// Name of the protocol.
    pub protocol: String,
    /// `true` where simulated people answered.
    pub simulated: bool,
    /// Participants, a record each.
    pub participants: Vec<Participant>,
    /// Ratings of each condition over all people, one value per person.
    pub ratings: Vec<Rated>,
    /// Compared pairs of conditions.
    pub comparisons: Vec<Comparison>,
    /// Drawings by condition, over all people.
    pub drawings: Vec<Drawn>,
    /// Choices between two conditions, over all people.
    pub choices: Vec<Chosen>,
    /// Confusion of wires: for each wire that was played, the number of answers by the wire nearest to them.
    pub confusion: Vec<Vec<u32>>,
    /// Median distance of a felt place from its wire, mm.
    pub localisation_mm: Option<Estimate>,
}

/// A participant's results.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Participant {
    /// Number of the participant.
    pub number: u32,
    /// `true` where every trial was answered.
    pub complete: bool,
    /// Trials that counted.
    pub trials: usize,
    /// Trials that were void and repeated.
    pub void: usize,
    /// Least level of each wire that is felt.
    pub thresholds: Vec<OfWire>,
    /// Least difference that is felt on each wire, a part of the amplitude.
    pub differences: Vec<OfWire>,
    /// Level at which each wire feels as strong as the reference.
    pub matches: Vec<OfWire>,
    /// Answers to the questions.
    pub answers: Vec<(String, String)>,
    /// Every drawing of the participant.
    pub drawings: Vec<OneDrawing>,
}

/// Estimate for a wire, dB, and its levels and answers.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct OfWire {
    /// Index of the wire, from zero.
    pub wire: u16,
    /// The estimate.
    pub estimate: Estimate,
    /// Levels that were asked at, answers that were yes, all answers.
    pub levels: Vec<(f64, u32, u32)>,
}

/// A drawing.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct OneDrawing {
    /// Number of its trial.
    pub trial: u32,
    /// Condition that was played.
    pub condition: String,
    /// Difference of the drawing from the path.
    pub error: PathError,
    /// The path that was played: seconds, mm.
    pub path: Vec<[f64; 3]>,
    /// Points of each stroke, mm; a break lies between two strokes.
    pub strokes: Vec<Vec<[f64; 2]>>,
}

/// Drawings of a condition over all people: medians of each person's.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Drawn {
    /// Condition that was played.
    pub condition: String,
    /// Number of drawings.
    pub drawings: usize,
    /// Median over people of [`PathError::rmse_mm`], mm.
    pub rmse_mm: Option<Estimate>,
    /// Median over people of [`PathError::frechet_mm`], mm.
    pub frechet_mm: Option<Estimate>,
    /// Mean of breaks marked per drawing.
    pub breaks: f64,
}

/// Ratings of a condition.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Rated {
    /// The scale.
    pub scale: String,
    /// Condition that was rated.
    pub condition: String,
    /// Each person's mean, sorted.
    pub values: Vec<f64>,
    /// Median of the values.
    pub median: Option<Estimate>,
}

/// Choices between the two conditions of a pair.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Chosen {
    /// The pair.
    pub pair: [String; 2],
    /// Share of all people's answers that chose the second one.
    pub part: Option<Estimate>,
    /// People who chose the second more often, people who chose the first more often.
    pub people: [u64; 2],
    /// Probability of so uneven a number of people where they have no preference (sign test).
    pub p: f64,
    /// Least value that `p` can have with so many people.
    pub least_p: f64,
}

impl Chosen {
    /// Reason for which the pair tells nothing, whatever was chosen; `None` where there are people enough.
    #[must_use]
    pub fn says_nothing(&self) -> Option<String> {
        let people: u64 = self.people.iter().sum();
        groups::too_few(&format!("{people} people with a preference"), self.least_p)
    }
}

impl Analysis {
    /// Adds comparisons with another study's ratings: each scale of each condition that both have, the other study
    /// first, under these names. Returns `false` where there is none.
    pub fn compare_ratings(&mut self, other: &Self, names: (&str, &str)) -> bool {
        let found: Vec<Comparison> = self
            .ratings
            .iter()
            .filter_map(|own| {
                let mut rated = other.ratings.iter();
                let like = |r: &&Rated| r.scale == own.scale && r.condition == own.condition;
                let of = format!("{} of {}", own.scale, own.condition);
                let groups = [&*rated.find(like)?.values, &*own.values];
                compared(&of, names, groups)
            })
            .collect();
        let any = !found.is_empty();
        // A comparison with simulated people is flagged as theirs.
        self.simulated |= any && other.simulated;
        self.comparisons.extend(found);
        any
    }
}

/// The most likely psychometric function where the threshold is known: of a few slopes the best.
#[must_use]
pub fn fitted(of: &OfWire, guess: f64) -> Psychometric {
    let with = |slope: f64| Psychometric {
        threshold: of.estimate.value,
        slope,
        guess,
        lapse: 0.02,
    };
    let likelihood = |function: &Psychometric| -> f64 {
        let each = of.levels.iter().map(|(level, yes, all)| {
            let p = function.correct(*level).clamp(1e-9, 1.0 - 1e-9);
            f64::from(*yes) * libm::log(p) + f64::from(all - yes) * libm::log(1.0 - p)
        });
        each.sum()
    };
    let slopes = (2..=20).map(|half| with(f64::from(half) / 2.0));
    let best = slopes.max_by(|a, b| likelihood(a).total_cmp(&likelihood(b)));
    best.unwrap_or(with(3.5))
}

/// Analyses records of one protocol.
///
/// # Errors
/// A record that is not of this protocol.
pub fn analyse(protocol: &Protocol, records: &[Record]) -> Result<Analysis, RecordError> {
    let people = records.iter().map(|record| participant(protocol, record));
    let participants = people.collect::<Result<Vec<_>, _>>()?;
    let ratings = ratings(protocol, records);
    let comparisons = comparisons(protocol, &ratings);
    let (confusion, localisation_mm) = places(records);
    Ok(Analysis {
        protocol: protocol.name.clone(),
        simulated: records.iter().any(|record| record.about.simulated),
        ratings,
        comparisons,
        drawings: drawn(&participants),
        choices: choices(protocol, records),
        confusion,
        localisation_mm,
        participants,
    })
}

fn participant(protocol: &Protocol, record: &Record) -> Result<Participant, RecordError> {
    use crate::session::{Reply, Step};
    let session = record.resumed(protocol.clone())?;
    let of = |task: TaskKind| -> Vec<OfWire> {
        let wires = session.estimates(task).into_iter();
        let whole = wires.map(|(wire, estimate)| OfWire {
            wire,
            estimate,
            levels: levels(protocol, record, task, wire),
        });
        whole.filter(|of| !of.levels.is_empty()).collect()
    };
    // A reply's question is the one that the session waited for.
    let mut again = crate::session::Session::new(
        protocol.clone(),
        record.about.participant,
        record.about.seed,
    );
    let mut answers = Vec::new();
    for said in record.replies() {
        if let (Step::Question(number), Reply::Chosen(choice)) = (again.step(), &said.reply) {
            let question = &protocol.questions[*number];
            let chosen = question.choices.get(*choice).cloned().unwrap_or_default();
            answers.push((question.name.clone(), chosen));
        }
        if again.take(&said.reply).is_err() {
            break; // it was replayed above without an error
        }
    }
    let drawings = record.counted().filter_map(|(played, answer)| {
        let Answer::Path(strokes) = answer else {
            return None;
        };
        let path = played.intervals.first()?.path.clone();
        let error = compare_paths(&path, strokes)?;
        let place = |s: &crate::session::Sample| [s.x_mm, s.y_mm];
        Some(OneDrawing {
            trial: played.number,
            condition: played.conditions().next()?.to_owned(),
            error,
            path,
            strokes: strokes
                .iter()
                .map(|s| s.iter().map(place).collect())
                .collect(),
        })
    });
    Ok(Participant {
        number: record.about.participant,
        complete: *session.step() == Step::Done,
        trials: record.counted().count(),
        void: record
            .replies()
            .filter(|said| matches!(said.reply, Reply::Void(_)))
            .count(),
        thresholds: of(TaskKind::AbsoluteThreshold),
        differences: of(TaskKind::Difference),
        matches: of(TaskKind::Matching),
        answers,
        drawings: drawings.collect(),
    })
}

/// Levels of a task's trials on a wire, with answers that were yes and all answers.
fn levels(protocol: &Protocol, record: &Record, task: TaskKind, wire: u16) -> Vec<(f64, u32, u32)> {
    let reference = protocol.matching.as_ref().map(|task| task.reference);
    let ours = record.counted().filter(|(played, _)| {
        let mut on = played.wires().map(|(on, _)| on);
        let other = |on: u16| task != TaskKind::Matching || Some(on) != reference;
        played.task == task && on.any(|on| on == wire && other(on))
    });
    // Levels are whole decibels.
    let mut counts: BTreeMap<i64, (u32, u32)> = BTreeMap::new();
    for (played, answer) in ours {
        if let (Some(level_db), Answer::Interval(chosen)) = (played.level_db, answer) {
            let count = counts.entry(level_db.round() as i64).or_default();
            count.0 += u32::from(played.right == Some(*chosen));
            count.1 += 1;
        }
    }
    let each = counts.into_iter();
    each.map(|(level, (yes, all))| (level as f64, yes, all))
        .collect()
}

/// Each person's mean of each condition on each scale.
fn ratings(protocol: &Protocol, records: &[Record]) -> Vec<Rated> {
    let Some(task) = &protocol.rating else {
        return Vec::new();
    };
    let mut rated = Vec::new();
    for (index, scale) in task.scales.iter().enumerate() {
        for condition in &task.conditions {
            let of_person = |record: &Record| {
                let ours = record
                    .counted()
                    .filter_map(|(played, answer)| match answer {
                        Answer::Ratings(ratings)
                            if played.conditions().next() == Some(condition) =>
                        {
                            ratings.get(index).copied()
                        }
                        _ => None,
                    });
                mean(ours.map(f64::from))
            };
            let mut values: Vec<f64> = records.iter().filter_map(of_person).collect();
            values.sort_unstable_by(f64::total_cmp);
            rated.push(Rated {
                scale: scale.name.clone(),
                condition: condition.clone(),
                median: median_within(&values),
                values,
            });
        }
    }
    rated
}

fn comparisons(protocol: &Protocol, ratings: &[Rated]) -> Vec<Comparison> {
    let Some(task) = &protocol.rating else {
        return Vec::new();
    };
    let of = |scale: &str, condition: &str| {
        let found = ratings
            .iter()
            .find(|r| r.scale == scale && r.condition == condition);
        found.map_or(&[][..], |r| &r.values)
    };
    let pairs = task
        .scales
        .iter()
        .flat_map(|scale| task.compare.iter().map(move |pair| (scale, pair)));
    let compared = pairs.filter_map(|(scale, [first, second])| {
        let groups = [of(&scale.name, first), of(&scale.name, second)];
        compared(&scale.name, (first, second), groups)
    });
    compared.collect()
}

fn drawn(participants: &[Participant]) -> Vec<Drawn> {
    let mut conditions: Vec<&str> = Vec::new();
    let all = participants.iter().flat_map(|p| &p.drawings);
    for drawing in all.clone() {
        if !conditions.contains(&drawing.condition.as_str()) {
            conditions.push(&drawing.condition);
        }
    }
    conditions.sort_unstable();
    let of = |condition: &str| {
        let ours = || all.clone().filter(|d| d.condition == condition);
        let person = |p: &Participant, figure: fn(&PathError) -> f64| {
            let own = p.drawings.iter().filter(|d| d.condition == condition);
            median(own.map(|d| figure(&d.error)))
        };
        let over = |figure: fn(&PathError) -> f64| {
            let each: Vec<f64> = participants
                .iter()
                .filter_map(|p| person(p, figure))
                .collect();
            median_within(&each)
        };
        Drawn {
            condition: condition.into(),
            drawings: ours().count(),
            rmse_mm: over(|e| e.rmse_mm),
            frechet_mm: over(|e| e.frechet_mm),
            breaks: mean(ours().map(|d| d.error.breaks as f64)).unwrap_or(0.0),
        }
    };
    conditions.into_iter().map(of).collect()
}

fn choices(protocol: &Protocol, records: &[Record]) -> Vec<Chosen> {
    let pairs = protocol.choice.iter().flat_map(|task| &task.pairs);
    let of = |pair: &[String; 2]| {
        let (mut yes, mut all, mut people) = (0, 0, [0, 0]);
        for record in records {
            let ours = record.counted().filter(|(played, _)| {
                let mut names = played.conditions();
                played.task == TaskKind::Choice && names.all(|name| pair.iter().any(|p| p == name))
            });
            let second = ours.filter_map(|(played, answer)| match answer {
                Answer::Interval(chosen) => Some(played.right == Some(*chosen)),
                _ => None,
            });
            let (mut own, mut asked) = (0u64, 0u64);
            for second in second {
                own += u64::from(second);
                asked += 1;
            }
            (yes, all) = (yes + own, all + asked);
            match (2 * own).cmp(&asked) {
                std::cmp::Ordering::Greater => people[0] += 1,
                std::cmp::Ordering::Less => people[1] += 1,
                std::cmp::Ordering::Equal => {}
            }
        }
        Chosen {
            pair: pair.clone(),
            part: proportion(yes, all),
            people,
            p: sign_test(people[0], people[0] + people[1]),
            least_p: least_sign_p(people[0] + people[1]),
        }
    };
    pairs.map(of).collect()
}

/// Confusion of wires, and the median distance of felt places from their wires, mm.
fn places(records: &[Record]) -> (Vec<Vec<u32>>, Option<Estimate>) {
    let mut confusion = Vec::new();
    let mut medians = Vec::new();
    for record in records {
        let wires = &record.about.wires_mm;
        if confusion.is_empty() {
            confusion = vec![vec![0; wires.len()]; wires.len()];
        }
        let away = |wire: &[f64; 2], [x, y]: [f64; 2]| libm::hypot(wire[0] - x, wire[1] - y);
        let mut off = Vec::new();
        for (played, answer) in record.counted() {
            let (Answer::Place(place), Some((wire, _))) = (answer, played.wires().next()) else {
                continue;
            };
            let nearest = (0..wires.len())
                .min_by(|a, b| away(&wires[*a], *place).total_cmp(&away(&wires[*b], *place)));
            let row = confusion.get_mut(usize::from(wire));
            if let (Some(row), Some(nearest)) = (row, nearest) {
                row[nearest] += 1;
                off.push(away(&wires[usize::from(wire)], *place));
            }
        }
        medians.extend(median(off));
    }
    let over = median_within(&medians);
    let any = over.is_some();
    (if any { confusion } else { Vec::new() }, over)
}
