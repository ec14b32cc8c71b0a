//! Response of a model to one property of a surface while all others stay, and rank correlations over materials whose
//! properties are independent.

use palpate_core::random::RandomStream;
use palpate_core::statistics;
use palpate_core::texture::Encoder;
use palpate_emulators::sensor::surface::{Explorer, Habits, Recording, SurfaceTexture, spearman};
use palpate_files::{Stands, TextureModel};
use palpate_run::Failure;
use rayon::prelude::*;
use serde::Serialize;

use crate::explore::latents;
use crate::world::{self, Factor};

/// Shares of their ranges at which the other properties stand.
const SETTINGS: [f64; 3] = [0.25, 0.5, 0.75];
/// Values of the property that is varied.
const VALUES: u32 = 9;
/// Factors, and properties among them.
const FACTORS: usize = Factor::ALL.len();
const PROPERTIES: usize = Factor::PROPERTIES.len();
/// Materials drawn with replacement, to see how sure a correlation is.
const RESAMPLED: usize = 500;

/// Response of a coordinate to one factor.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Answer {
    /// Spearman's rank correlation of the coordinate with the factor, the mean of three settings of the others.
    pub rank: f64,
    /// Range of the coordinate over the factor's range, the mean of three settings, as a share of its range over
    /// everything that was tried.
    pub span: f64,
}

/// A rank correlation, others held, with its 95 % interval.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Partial {
    /// Correlation over all materials.
    pub rank: f64,
    /// 2.5 % of the resampled ones lie below.
    pub low: f64,
    /// 2.5 % lie above.
    pub high: f64,
}

/// A coordinate of a model.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Coordinate {
    /// Number of the coordinate, from 1, as in `z1`.
    pub number: usize,
    /// Direction: -1 where all figures are of the coordinate turned round, by the model's file.
    pub sign: i8,
    /// Property that the coordinate stands for by the model's file; empty where the file names none.
    pub stands_for: &'static str,
    /// Answers by factor, in the order of [`Factor::ALL`].
    pub answers: [Answer; FACTORS],
    /// Correlations by property, in the order of [`Factor::PROPERTIES`]; `None` without materials.
    pub partial: Option<[Partial; PROPERTIES]>,
}

impl Coordinate {
    /// Property that the coordinate is meant to tell; where the file names none, the property with the largest span.
    pub fn own(&self) -> Factor {
        match self.stands_for {
            "roughness" => Factor::Relief,
            "hardness" => Factor::Stiffness,
            "friction" => Factor::Friction,
            _ => {
                let spans = Factor::PROPERTIES.iter().zip(&self.answers);
                let furthest = spans.max_by(|a, b| a.1.span.total_cmp(&b.1.span));
                *furthest.map_or(&Factor::Relief, |(factor, _)| factor)
            }
        }
    }

    /// Span of the coordinate over a factor divided by its span over its own property; `None` where it does not answer
    /// its own.
    pub fn crosstalk(&self, factor: Factor) -> Option<f64> {
        let own = self.answer(self.own()).span;
        (own > 0.0).then(|| self.answer(factor).span / own)
    }

    /// Response of the coordinate to a factor.
    pub fn answer(&self, factor: Factor) -> Answer {
        let place = Factor::ALL.iter().position(|of| *of == factor);
        place.map_or_else(Answer::default, |place| self.answers[place])
    }
}

/// One property over its range, the others at one setting.
struct Condition {
    factor: Factor,
    surface: SurfaceTexture,
    habits: Habits,
}

/// Number of surfaces that [`response`] strokes.
pub const fn surfaces(materials: u32) -> u32 {
    (FACTORS * SETTINGS.len()) as u32 * VALUES + materials
}

/// All conditions: by factor, by setting, by value.
fn conditions() -> Vec<Condition> {
    let mut all = Vec::new();
    for factor in Factor::ALL {
        for setting in SETTINGS {
            for value in 0..VALUES {
                // One name, so that every condition has the same draws of the relief and of the hand.
                let mut surface = world::at_share("probe".to_owned(), |_| setting);
                let mut habits = Habits::default();
                let share = f64::from(value) / f64::from(VALUES - 1);
                factor.set(&mut surface, &mut habits, factor.at(share));
                all.push(Condition {
                    factor,
                    surface,
                    habits,
                });
            }
        }
    }
    all
}

/// Each coordinate's mean over all windows of some strokes.
fn mean(
    (model, encoder): (&TextureModel, &Encoder),
    strokes: &[Recording],
) -> Result<Vec<f64>, Failure> {
    let mut sum = vec![0.0; model.latents()];
    let mut count = 0.0;
    for stroke in strokes {
        for z in latents((model, encoder), stroke)? {
            sum.iter_mut()
                .zip(&z)
                .for_each(|(s, z)| *s += f64::from(*z));
            count += 1.0;
        }
    }
    sum.iter_mut().for_each(|s| *s /= count);
    Ok(sum)
}

/// Measures the response of a model. With `materials`, that many are drawn that the model never saw, each stroked with
/// varied habits; `passed` is called after every one of the [`surfaces`].
///
/// # Errors
/// A model whose features are no columns of a flat module, or whose window is longer than a stroke.
pub fn response(
    model: &TextureModel,
    (strokes, materials): (u32, usize),
    (dead, seed): (Option<usize>, u64),
    passed: impl Fn() + Sync,
) -> Result<Vec<Coordinate>, Failure> {
    let encoder = model.encoder()?;
    let of = |surface: &SurfaceTexture, habits: Habits| {
        let mut explorer = Explorer::new(habits, dead, seed);
        let all: Vec<_> = (0..strokes).map(|n| explorer.stroke(surface, n)).collect();
        passed();
        mean((model, &encoder), &all)
    };
    let asked = conditions();
    let probed: Vec<Vec<f64>> = asked
        .par_iter()
        .map(|c| of(&c.surface, c.habits))
        .collect::<Result<_, _>>()?;
    let drawn = world::draw_unseen(materials, seed);
    let felt: Vec<Vec<f64>> = drawn
        .par_iter()
        .map(|material| of(material, Habits::varied()))
        .collect::<Result<_, _>>()?;
    let standing = model.standing();
    let named = [
        ("roughness", standing.roughness),
        ("friction", standing.friction),
        ("hardness", standing.hardness),
    ];
    let coordinate = |number: usize| {
        let of =
            |one: &&(&'static str, Option<Stands>)| one.1.is_some_and(|s| s.coordinate == number);
        let found = named.iter().find(of);
        let stands_for = found.map_or("", |(name, _)| *name);
        let sign = match found.and_then(|(_, stands)| *stands) {
            Some(stands) if stands.sign < 0 => -1,
            _ => 1,
        };
        let values = |all: &[Vec<f64>]| -> Vec<f64> {
            all.iter().map(|z| f64::from(sign) * z[number]).collect()
        };
        Coordinate {
            number: number + 1,
            sign,
            stands_for,
            answers: answers(&asked, &values(&probed)),
            partial: (materials > PROPERTIES).then(|| partials(&drawn, &values(&felt), seed)),
        }
    };
    Ok((0..model.latents()).map(coordinate).collect())
}

/// Crosstalk of a coordinate over several seeds.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Spread {
    /// Median over the seeds.
    pub median: f64,
    /// Least of all seeds.
    pub least: f64,
    /// Largest of all seeds.
    pub largest: f64,
}

/// Crosstalk of a coordinate, by its place, with a factor over responses of several seeds; `None` where it does not answer its
/// own property in each of them.
pub fn spread(seeds: &[Vec<Coordinate>], place: usize, factor: Factor) -> Option<Spread> {
    let of = |found: &Vec<Coordinate>| found.get(place)?.crosstalk(factor);
    let mut all = seeds.iter().map(of).collect::<Option<Vec<f64>>>()?;
    all.sort_unstable_by(f64::total_cmp);
    let middle = [
        all.get(all.len().checked_sub(1)? / 2)?,
        all.get(all.len() / 2)?,
    ];
    Some(Spread {
        median: middle.into_iter().sum::<f64>() / 2.0,
        least: *all.first()?,
        largest: *all.last()?,
    })
}

/// Range of values: largest less smallest.
fn span(values: &[f64]) -> f64 {
    let (low, high) = values
        .iter()
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), v| {
            (low.min(*v), high.max(*v))
        });
    (high - low).max(0.0)
}

fn answers(asked: &[Condition], values: &[f64]) -> [Answer; FACTORS] {
    let whole = span(values);
    let steps: Vec<f64> = (0..VALUES).map(f64::from).collect();
    Factor::ALL.map(|factor| {
        let of: Vec<f64> = asked
            .iter()
            .zip(values)
            .filter(|(c, _)| c.factor == factor)
            .map(|(_, value)| *value)
            .collect();
        let settings = of.chunks_exact(VALUES as usize);
        let rank = settings.clone().map(|s| spearman(s, &steps));
        let rank = statistics::mean(rank).unwrap_or(f64::NAN);
        let far = statistics::mean(settings.map(span)).unwrap_or(f64::NAN);
        Answer {
            rank,
            span: if whole > 0.0 { far / whole } else { 0.0 },
        }
    })
}

/// Correlation of a coordinate with each property, the other properties held: partial rank correlations, with intervals
/// by resampling.
fn partials(materials: &[SurfaceTexture], values: &[f64], seed: u64) -> [Partial; PROPERTIES] {
    let mut columns = vec![values.to_vec()];
    for factor in Factor::PROPERTIES {
        columns.push(materials.iter().filter_map(|m| factor.value(m)).collect());
    }
    let found = each_held(&columns);
    let mut stream = RandomStream::new(seed, "resampled materials");
    let mut again: [Vec<f64>; PROPERTIES] = Default::default();
    for _ in 0..RESAMPLED {
        let count = values.len();
        let draw = |_| ((stream.uniform() * count as f64) as usize).min(count - 1);
        let picked: Vec<usize> = (0..count).map(draw).collect();
        let some = columns
            .iter()
            .map(|c| picked.iter().map(|n| c[*n]).collect());
        let some: Vec<Vec<f64>> = some.collect();
        let each = each_held(&some);
        again.iter_mut().zip(each).for_each(|(all, r)| all.push(r));
    }
    let mut intervals = again.into_iter().map(|mut all| {
        all.sort_unstable_by(f64::total_cmp);
        let at = |share: f64| all[(share * (RESAMPLED - 1) as f64).round() as usize];
        (at(0.025), at(0.975))
    });
    found.map(|rank| {
        let (low, high) = intervals.next().unwrap_or_default();
        Partial { rank, low, high }
    })
}

/// The first column with each other one, the rest held.
fn each_held(columns: &[Vec<f64>]) -> [f64; PROPERTIES] {
    let mut ranks = vec![vec![1.0; columns.len()]; columns.len()];
    for a in 0..columns.len() {
        for b in 0..a {
            let rank = spearman(&columns[a], &columns[b]);
            (ranks[a][b], ranks[b][a]) = (rank, rank);
        }
    }
    std::array::from_fn(|n| {
        let held: Vec<usize> = (1..columns.len()).filter(|c| *c != n + 1).collect();
        partial(&ranks, (0, n + 1), &held)
    })
}

/// The correlation of a pair, `held` left out one by one.
fn partial(ranks: &[Vec<f64>], (a, b): (usize, usize), held: &[usize]) -> f64 {
    let Some((&last, rest)) = held.split_last() else {
        return ranks[a][b];
    };
    let of = |a, b| partial(ranks, (a, b), rest);
    let (ab, al, bl) = (of(a, b), of(a, last), of(b, last));
    let left = (1.0 - al * al) * (1.0 - bl * bl);
    if left > 0.0 {
        (ab - al * bl) / left.sqrt()
    } else {
        0.0
    }
}

#[cfg(test)]
#[path = "response_tests.rs"]
mod tests;
