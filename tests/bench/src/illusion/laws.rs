//! Fair table of laws in the loop, with guard and heat: each law gets the same search space, budget and objective on seeds
//! that do not score it, and is scored moving, at rest and over ten minutes.

mod space;
mod table;

use palpate_core::illusion::IllusionModel;
use palpate_files::{Loaded, Setup, Source, load_bench};
use palpate_records::felt::FeltPath;
use palpate_records::measure::Errors;
use palpate_records::trace::{Event, FeltAt, event};
use palpate_run::{Failure, Input, Outcome, run};
use palpate_tests::felt::PATHS;
use rayon::prelude::*;

use crate::findings::{Findings, NO_ERROR};
use space::{GIVEN, Knobs};

/// Points that every law is tried at, where the command line says nothing else.
pub const POINTS: u32 = 64;
/// Seeds that choose the settings, and those that score them.
const CHOOSING: [u64; 3] = [6, 7, 8];
pub(super) const SCORING: [u64; 5] = [1, 2, 3, 4, 5];
/// Cost of a run of which nothing is felt, mm; a part of the onsets costs that part.
const UNFELT_MM: f64 = 10.0;
/// Bench of the table and of the figure.
pub(super) const BENCH: &str = "emulated";

/// Name of the contact at rest among the scenes of the objective.
const REST: &str = "rest";

/// Situations in which a law is scored.
const SITUATIONS: [&str; 3] = [
    "moving, four paths",
    "at rest, 10 s",
    "moving along, ten minutes",
];

/// Felt result of a run, or of several.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Felt {
    /// Median level of the onsets inside the wires' hull, dB.
    level_db: f64,
    /// Root mean square by energy and amplitude centroid, mm; infinite where no wire moved.
    inside_mm: [f64; 2],
    /// The larger of both over all onsets, inside the hull or not, mm.
    everywhere_mm: f64,
    inside: Count,
    everywhere: Count,
    /// Onsets inside the hull that are felt as taps, not as vibrations.
    taps: u64,
    limited: u32,
}

/// Onsets, and those of them that stay below the threshold.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
struct Count {
    onsets: u32,
    unfelt: u32,
}

impl Count {
    fn add(&mut self, is_felt: bool) {
        self.onsets += 1;
        self.unfelt += u32::from(!is_felt);
    }

    const fn with(self, other: Self) -> Self {
        Self {
            onsets: self.onsets + other.onsets,
            unfelt: self.unfelt + other.unfelt,
        }
    }
}

impl Felt {
    fn new(outcome: &Outcome) -> Self {
        let trace = &outcome.trace;
        let mut path = FeltPath::new(&trace.header);
        let (mut inner, mut all) = (Count::default(), Count::default());
        for event in &trace.events {
            path.add(event);
            if let Event::Felt(event::Felt { inside, met, .. }) = event {
                let is_felt = met.as_ref().is_some_and(FeltAt::is_felt);
                all.add(is_felt);
                if *inside {
                    inner.add(is_felt);
                }
            }
        }
        let level = path.level();
        let scores = path.scores();
        let mm = |errors: Option<Errors>| {
            errors.map_or(f64::INFINITY, |errors| errors.rmse_um as f64 * 1e-3)
        };
        let [energy, amplitude] = scores.map(|score| mm(score.everywhere));
        Self {
            level_db: level.map_or(f64::NEG_INFINITY, |l| f64::from(l.median_mdb) * 1e-3),
            inside_mm: scores.map(|score| mm(score.errors)),
            everywhere_mm: energy.max(amplitude),
            inside: inner,
            everywhere: all,
            taps: level.map_or(0, |l| l.taps),
            limited: trace.ledger.driven.limiter_events,
        }
    }

    fn worst_mm(&self) -> f64 {
        self.inside_mm[0].max(self.inside_mm[1])
    }

    /// Cost of a run, mm: its larger error inside the hull, and the share of the onsets there that are not felt.
    fn cost(&self) -> f64 {
        let share = f64::from(self.inside.unfelt) / f64::from(self.inside.onsets.max(1));
        self.worst_mm() + UNFELT_MM * share
    }

    /// Two runs as one: the lower level, the larger errors, counts together.
    fn with(self, other: Self) -> Self {
        Self {
            level_db: self.level_db.min(other.level_db),
            inside_mm: [0, 1].map(|k: usize| self.inside_mm[k].max(other.inside_mm[k])),
            everywhere_mm: self.everywhere_mm.max(other.everywhere_mm),
            inside: self.inside.with(other.inside),
            everywhere: self.everywhere.with(other.everywhere),
            taps: self.taps + other.taps,
            limited: self.limited + other.limited,
        }
    }
}

/// Settings found for a law.
#[derive(Clone, Debug)]
struct Chosen {
    law: IllusionModel,
    knobs: Option<Knobs>,
    /// Number of the point in the sequence.
    point: u32,
    cost_mm: f64,
    /// Points that the loop refuses, such as a duration that a bench cannot play.
    refused: u32,
}

/// A law with its settings, its score in each of [`SITUATIONS`] for each of [`SCORING`].
struct Scored {
    chosen: Chosen,
    by_seed: Vec<[Felt; 3]>,
}

/// A whole run; a run that ended early is a failure.
pub(super) fn play(setup: &Setup, seed: u64) -> Result<Outcome, Failure> {
    let outcome = run(setup, &Input::Scene, seed)?;
    match outcome.failure {
        Some(failure) => Err(failure),
        None => Ok(outcome),
    }
}

fn felt(setup: &Setup, seed: u64) -> Result<Felt, Failure> {
    Ok(Felt::new(&play(setup, seed)?))
}

/// A scene of the objective on the bench: a path, or the contact at rest.
fn setup(scene: &str) -> Result<Setup, Failure> {
    if scene != REST {
        return Ok(Setup::load(scene, BENCH)?);
    }
    let rest = Source::new("rest.toml", include_str!("rest.toml"));
    Ok(Setup::join(Loaded::read(rest)?, load_bench(BENCH)?)?)
}

/// Cost of a point over all paths, the rest and the choosing seeds, the worst run's; `None` as soon as it cannot be
/// below `below_mm`.
fn cost(law: IllusionModel, point: u32, below_mm: f64) -> Result<Option<f64>, Failure> {
    let knobs = space::point(point);
    let overrides = space::overrides(law, knobs.as_ref());
    let mut worst = 0.0_f64;
    for scene in PATHS.into_iter().chain([REST]) {
        let setup = setup(scene)?.with(&overrides)?;
        for seed in CHOOSING {
            worst = worst.max(felt(&setup, seed)?.cost());
            if worst >= below_mm {
                return Ok(None);
            }
        }
    }
    Ok(Some(worst))
}

/// The best of so many points; the law's own settings where no wire ever moves.
fn choose(law: IllusionModel, points: u32) -> Result<Chosen, Failure> {
    let mut best = (f64::INFINITY, 0);
    let (mut refused, mut refusal) = (0, None);
    for point in 0..points {
        match cost(law, point, best.0) {
            Ok(Some(mm)) => best = (mm, point),
            Ok(None) => {}
            Err(failure) => {
                refused += 1;
                refusal = Some(failure);
            }
        }
    }
    if let Some(failure) = refusal.filter(|_| refused == points) {
        return Err(failure);
    }
    Ok(Chosen {
        law,
        knobs: space::point(best.1),
        point: best.1,
        cost_mm: best.0,
        refused,
    })
}

fn score(chosen: &Chosen, seed: u64) -> Result<[Felt; 3], Failure> {
    let overrides = space::overrides(chosen.law, chosen.knobs.as_ref());
    let mut moving: Option<Felt> = None;
    for scene in PATHS {
        let one = felt(&setup(scene)?.with(&overrides)?, seed)?;
        moving = Some(moving.map_or(one, |all| all.with(one)));
    }
    let rest = felt(&setup(REST)?.with(&overrides)?, seed)?;
    let mut long = overrides;
    long.scene("laws", "length_s", "600.0");
    let long = felt(&setup(PATHS[0])?.with(&long)?, seed)?;
    Ok([moving.unwrap_or(rest), rest, long])
}

/// Searches and scores every law; which processor computes what changes no figure.
///
/// # Errors
/// [`Failure`] where a shipped file cannot be read, or a law refuses every point.
pub fn measure(points: u32) -> Result<Findings, Failure> {
    let points = points.max(GIVEN);
    let laws = IllusionModel::ALL.into_par_iter().with_max_len(1);
    let chosen = laws
        .map(|law| choose(law, points))
        .collect::<Result<Vec<_>, Failure>>()?;
    let jobs: Vec<(&Chosen, u64)> = chosen
        .iter()
        .flat_map(|law| SCORING.map(|seed| (law, seed)))
        .collect();
    let jobs = jobs.into_par_iter().with_max_len(1);
    let scores = jobs
        .map(|(law, seed)| score(law, seed))
        .collect::<Result<Vec<_>, Failure>>()?;
    let scored: Vec<Scored> = chosen
        .iter()
        .zip(scores.chunks(SCORING.len()))
        .map(|(chosen, by_seed)| Scored {
            chosen: chosen.clone(),
            by_seed: by_seed.to_vec(),
        })
        .collect();
    let mut found = Findings::new("laws");
    for law in &scored {
        for (k, situation) in SITUATIONS.iter().enumerate() {
            let mm = law.by_seed.iter().map(|by| by[k].worst_mm());
            let mm = mm.fold(0.0, f64::max);
            let error = if mm.is_finite() {
                (mm, "mm RMSE inside the hull, the worse centroid")
            } else {
                NO_ERROR
            };
            found.row(situation, law.chosen.law.name(), error, f64::NAN);
        }
    }
    found.table = table::markdown(&scored, points);
    Ok(found)
}

#[cfg(test)]
#[path = "laws_tests.rs"]
mod tests;
