//! Every law in the loop, with guard and heat: scenes, benches, wires and seeds, as three persons feel them.
//!
//! A person changes nothing that is driven. So each run is played by two probes who feel anything at all, one by each
//! channel, and a person's level is theirs, shifted by the thresholds.

mod table;

use std::num::NonZeroUsize;
use std::thread;

use palpate_core::contact::Levels;
use palpate_core::illusion::{IllusionModel, Map};
use palpate_emulators::person::channels::Person;
use palpate_files::{Loaded, Overrides, Scene, Setup, Source, load_bench, load_person, load_scene};
use palpate_records::felt::FeltPath;
use palpate_records::trace::{Event, Header, event};
use palpate_run::{Failure, Input, Outcome, build, plan, run};
use palpate_tests::felt::PATHS;

use super::bound::Bound;
use crate::findings::Findings;

/// A bench as this comparison has it.
#[derive(Clone, Copy, PartialEq)]
pub(super) struct Drive {
    pub(super) name: &'static str,
    pub(super) file: &'static str,
    /// Current in place of the file's.
    ma: Option<f64>,
    /// Files of its wires: loose, taut.
    pub(super) wires: [&'static str; 2],
    /// Error on a path that is a law's own, mm RMSE at most; none is required of the weaker.
    law_mm: Option<f64>,
}

/// The default bench, the published drive, and one weaker than the default.
pub(super) const DRIVES: [Drive; 3] = [
    Drive {
        name: "default",
        file: "emulated",
        ma: None,
        wires: ["loose-50um", "taut"],
        law_mm: Some(0.8),
    },
    Drive {
        name: "1.0 A",
        file: "emulated",
        ma: Some(1000.0),
        wires: ["loose-50um", "taut"],
        law_mm: None,
    },
    Drive {
        name: "thesis",
        file: "thesis",
        ma: None,
        wires: ["final-75um", "taut"],
        law_mm: Some(1.0),
    },
];
/// Persons; the table shows breaks of each and levels of the second.
const PERSONS: [&str; 3] = ["sensitive", "typical", "dull"];
/// Scenes beside the four paths: a contact at rest, one that presses, and two.
const OTHERS: [&str; 3] = ["rest", "press", "two-finger-press"];
pub(super) const SEEDS: [u64; 5] = [1, 2, 3, 4, 5];
/// Thresholds of who feels anything, and of who feels nothing by a channel, um.
const PROBE_UM: f64 = 1e-6;
const NUMB_UM: f64 = 1e6;

/// Case that is run.
#[derive(Clone, Copy)]
pub(super) struct Case {
    pub(super) law: IllusionModel,
    pub(super) drive: Drive,
    /// Kind of the wires.
    pub(super) wires: &'static str,
    pub(super) scene: &'static str,
}

/// An onset as the first probe meets it, and the second one's level, thousandths of a decibel.
type Onset = (Event, Option<i32>);

/// A run, before a person feels it.
pub(super) struct Played {
    pub(super) outcome: Outcome,
    pub(super) onsets: Vec<Onset>,
}

/// A scene of the benchmark's own, or a shipped one.
fn scene(name: &str) -> Result<Loaded<Scene>, Failure> {
    let text = match name {
        "rest" => include_str!("rest.toml"),
        "press" => include_str!("press.toml"),
        shipped => return Ok(load_scene(shipped)?),
    };
    let source = Source::new(format!("{name}.toml"), text);
    Ok(Loaded::read(source)?)
}

impl Case {
    fn setup(&self) -> Result<Setup, Failure> {
        let mut overrides = Overrides::default();
        overrides.scene("illusion", "illusion.model", self.law.name());
        if let Some(ma) = self.drive.ma {
            overrides.bench("illusion", "drive.current_ma", format!("{ma:.1}"));
        }
        overrides.bench("illusion", "wire.kind", self.wires);
        let setup = Setup::join(scene(self.scene)?, load_bench(self.drive.file)?)?;
        Ok(setup.with(&overrides)?)
    }

    /// Plays it to both probes.
    pub(super) fn play(&self, seed: u64) -> Result<Played, Failure> {
        let mut setup = self.setup()?;
        let mut by = |vibration_um, flutter_um| {
            setup.person.value.vibration.threshold_um.value = vibration_um;
            setup.person.value.vibration.area_cm2 = None;
            setup.person.value.flutter.threshold_um.value = flutter_um;
            let outcome = run(&setup, &Input::Scene, seed)?;
            match outcome.failure {
                Some(failure) => Err(failure),
                None => Ok(outcome),
            }
        };
        let (vibration, flutter) = (by(PROBE_UM, NUMB_UM)?, by(NUMB_UM, PROBE_UM)?);
        let felt = |event: &&Event| matches!(event, Event::Felt(_));
        let of_flutter = flutter
            .trace
            .events
            .iter()
            .filter(felt)
            .map(|event| match event {
                Event::Felt(event::Felt { met, .. }) => met.map(|met| met.level_mdb),
                _ => None,
            });
        let of_vibration = vibration.trace.events.iter().filter(felt).cloned();
        Ok(Played {
            onsets: of_vibration.zip(of_flutter).collect(),
            outcome: vibration,
        })
    }
}

/// Thousandths of a decibel that a threshold lies above the probes'.
fn above_mdb(um: f64) -> i32 {
    (20e3 * (um / PROBE_UM).log10()).round() as i32
}

/// An onset as a person meets it.
pub(super) fn met((event, flutter_mdb): &Onset, person: &Person) -> Event {
    let mut event = event.clone();
    if let Event::Felt(event::Felt { met: Some(met), .. }) = &mut event {
        let vibration = met.level_mdb - above_mdb(person.vibration_um);
        let flutter = flutter_mdb.map(|mdb| mdb - above_mdb(person.flutter_um));
        met.level_mdb = flutter.map_or(vibration, |flutter| vibration.max(flutter));
    }
    event
}

/// Judgement of a run by a person: errors by both centroids, level, breaks, jumps. Over seeds, the worst of each.
#[derive(Clone, Copy, Debug, Default)]
struct Score {
    /// Root mean square, energy and amplitude centroid, mm.
    mm: [Option<f64>; 2],
    /// Median and 5 %, dB.
    level_db: Option<[f64; 2]>,
    breaks: u64,
    jumps: u64,
}

impl Score {
    fn of(header: &Header, played: &Played, person: &Person) -> Self {
        let mut path = FeltPath::new(header);
        played
            .onsets
            .iter()
            .for_each(|onset| path.add(&met(onset, person)));
        let scores = path.scores();
        let db = |mdb: i32| f64::from(mdb) * 1e-3;
        Self {
            mm: scores.map(|s| s.errors.map(|e| e.rmse_um as f64 * 1e-3)),
            level_db: path.level().map(|l| [db(l.median_mdb), db(l.p5_mdb)]),
            breaks: scores[0].breaks,
            jumps: scores.map(|s| s.jumps).into_iter().max().unwrap_or(0),
        }
    }

    /// The larger error, mm; NaN where nothing was felt.
    fn worst_mm(&self) -> f64 {
        let [energy, amplitude] = self.mm.map(|mm| mm.unwrap_or(f64::NAN));
        energy.max(amplitude)
    }

    fn worse(self, other: Self) -> Self {
        let larger = |a: Option<f64>, b: Option<f64>| match (a, b) {
            (Some(a), Some(b)) => Some(a.max(b)),
            (a, b) => a.or(b),
        };
        let lower = |a: [f64; 2], b: [f64; 2]| [a[0].min(b[0]), a[1].min(b[1])];
        Self {
            mm: [0, 1].map(|k| larger(self.mm[k], other.mm[k])),
            level_db: match (self.level_db, other.level_db) {
                (Some(a), Some(b)) => Some(lower(a, b)),
                (a, b) => a.or(b),
            },
            breaks: self.breaks.max(other.breaks),
            jumps: self.jumps.max(other.jumps),
        }
    }
}

/// Results of a case, the worst of its seeds.
#[derive(Clone, Copy, Debug, Default)]
struct Figures {
    /// By each of [`PERSONS`].
    by: [Score; 3],
    skin_c: f64,
    wire_c: f64,
    limited: u32,
    energy_mj: f64,
    /// Bound on the error that the typical person may feel; only for the four paths.
    bound: Option<Bound>,
}

impl Figures {
    fn of(played: &Played, persons: &[Person; 3], (case, map): (&Case, &Map)) -> Self {
        let trace = &played.outcome.trace;
        let (header, summary) = (&trace.header, &played.outcome.summary);
        let by = persons
            .each_ref()
            .map(|person| Score::of(header, played, person));
        let is_path = PATHS.contains(&case.scene);
        let bound = || Bound::of(trace, map, by[1].worst_mm(), case.drive.law_mm);
        Self {
            bound: is_path.then(bound).flatten(),
            by,
            skin_c: summary.hottest_skin_c.unwrap_or(f64::NAN),
            wire_c: summary.hottest_wire_c.unwrap_or(f64::NAN),
            limited: summary.limiter_events,
            energy_mj: summary.energy_mj.unwrap_or(f64::NAN),
        }
    }

    fn worse(self, other: Self) -> Self {
        Self {
            by: [0, 1, 2].map(|k| self.by[k].worse(other.by[k])),
            skin_c: self.skin_c.max(other.skin_c),
            wire_c: self.wire_c.max(other.wire_c),
            limited: self.limited.max(other.limited),
            energy_mj: self.energy_mj.max(other.energy_mj),
            bound: match (self.bound, other.bound) {
                (Some(a), Some(b)) => Some(a.worse(b)),
                (a, b) => a.or(b),
            },
        }
    }
}

/// Every case, scenes fastest, then laws.
fn cases() -> Vec<Case> {
    let mut cases = Vec::new();
    for drive in DRIVES {
        for wires in drive.wires {
            for law in IllusionModel::ALL {
                let scenes = PATHS.into_iter().chain(OTHERS);
                cases.extend(scenes.map(|scene| Case {
                    law,
                    drive,
                    wires,
                    scene,
                }));
            }
        }
    }
    cases
}

/// The worst of a case's seeds.
fn figures(case: &Case) -> Result<Figures, Failure> {
    let mut worst: Option<Figures> = None;
    let setup = case.setup()?;
    let persons = persons(&setup)?;
    let map = *build(&setup, SEEDS[0], Levels::Off)?.map();
    for seed in SEEDS {
        let one = Figures::of(&case.play(seed)?, &persons, (case, &map));
        worst = Some(worst.map_or(one, |worst| worst.worse(one)));
    }
    Ok(worst.unwrap_or_default())
}

/// All cases on every processor; which one computes what changes no figure.
fn all(cases: &[Case]) -> Result<Vec<Figures>, Failure> {
    let lanes = thread::available_parallelism().map_or(1, NonZeroUsize::get);
    let lane = |first: usize| {
        let mine = cases.iter().enumerate().skip(first).step_by(lanes);
        mine.map(|(n, case)| Ok((n, figures(case)?)))
            .collect::<Result<Vec<_>, Failure>>()
    };
    let lane = &lane;
    let parts = thread::scope(|scope| {
        let started: Vec<_> = (0..lanes).map(|n| scope.spawn(move || lane(n))).collect();
        let ended = started.into_iter().map(|part| match part.join() {
            Ok(part) => part,
            Err(panic) => std::panic::resume_unwind(panic),
        });
        ended.collect::<Result<Vec<_>, Failure>>()
    })?;
    let mut each: Vec<_> = parts.into_iter().flatten().collect();
    each.sort_by_key(|part| part.0);
    Ok(each.into_iter().map(|part| part.1).collect())
}

/// One of the persons, with a bench's wires.
pub(super) fn person(name: &str, setup: &Setup) -> Result<Person, Failure> {
    let tissue = setup.bench.value.tissue.parameters();
    let wire = plan::wire(setup);
    Ok(plan::person(&load_person(name)?.value, &wire, &tissue))
}

/// Every one of [`PERSONS`], with a bench's wires.
fn persons(setup: &Setup) -> Result<[Person; 3], Failure> {
    let [a, b, c] = PERSONS;
    Ok([person(a, setup)?, person(b, setup)?, person(c, setup)?])
}

/// A law's name here: the default is called so.
pub(super) fn law(model: IllusionModel) -> &'static str {
    match model == IllusionModel::default() {
        true => "default",
        false => model.name(),
    }
}

/// Measures everything.
///
/// # Errors
/// [`Failure`] where a shipped file cannot be read, or a run fails.
pub fn measure() -> Result<Findings, Failure> {
    let cases = cases();
    let figures = all(&cases)?;
    let mut found = Findings::new("felt-in-loop");
    for (case, figures) in cases.iter().zip(&figures) {
        for (person, score) in PERSONS.into_iter().zip(&figures.by) {
            let (drive, scene, wires) = (case.drive.name, case.scene, case.wires);
            let name = format!("{drive}, {scene}, {wires}, {person}");
            let error = (score.worst_mm(), "mm RMSE, the worse centroid");
            found.row(&name, law(case.law), error, f64::NAN);
        }
    }
    found.table = table::text(&cases, &figures);
    let [a, b, c] = PERSONS;
    found.words.push(format!(
        "Worst of {} seeds. Errors are by energy and amplitude centroid against the touch, felt or not. Levels are the \
         typical person's, median and 5 %. Breaks are those of {a}, {b} and {c}; jumps, over two centroids, the typical \
         person's. Two contacts are scored where one is shown alone. Of the paths: the error of the contact path on the display \
         in the run that uses up most of what the error may be, the law's 0.8 mm (1.0 mm on the thesis's bench) and the path's \
         added in squares; and whether every run keeps to it.",
        SEEDS.len(),
    ));
    Ok(found)
}

#[cfg(test)]
#[path = "in_loop_tests.rs"]
mod tests;
