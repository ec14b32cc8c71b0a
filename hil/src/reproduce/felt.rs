//! Rows of figure 5.5: four paths of a sphere, their contacts, and what the typical person feels of them on each
//! hypothesis of the wire.

use palpate_core::random::RandomStream;
use palpate_files::{Bench, Overrides, Scene, Seat, Setup};
use palpate_records::trace::event;
use palpate_run::{Failure, Input, Outcome, run};
use serde_json::{Value, json};

use super::row::{Answer, Mark, Row};
use super::setups;

pub(super) const ROWS: &[Row] = &[
    Row {
        id: "fig-5.5-A",
        says: "One contact follows the sphere accurately and smoothly on four paths.",
        assumed: "The shipped scenes of four paths; accurate is within a tenth of the pitch, 0.47 mm RMSE.",
        compute: contacts,
    },
    Row {
        id: "fig-5.5-B",
        says: "Up to 12 of 16 taxels (75 %) are in contact at once.",
        assumed: "The shipped scenes: 0.4 to 1 N, threshold of (4.3) and 10 counts. The emulated skin's spread was set to this number, so agreement says little.",
        compute: taxels,
    },
    Row {
        id: "fig-5.5-B-speed",
        says: "Compression with K_C = 1 is well above the sensor's 100 Hz.",
        assumed: "This machine, one core: the whole loop.",
        compute: speed,
    },
    Row {
        id: "fig-5.5-C-taut",
        says: "Both users felt and drew all four paths, mostly where they were.",
        assumed: "Wires at the vendor's tension, cold; (5.2) at the published current and timing.",
        compute: || feels(&Hypothesis::new("thesis", "taut", false)),
    },
    Row {
        id: "fig-5.5-C-cold",
        says: "Both users felt and drew all four paths, mostly where they were.",
        assumed: "The final module's wires, cold; (5.2) at the published current and timing.",
        compute: || feels(&Hypothesis::new("thesis", "final-75um", false)),
    },
    Row {
        id: "fig-5.5-C-passed",
        says: "Both users felt and drew all four paths, mostly where they were.",
        assumed: "The final module's wires after a hot pass; (5.2) at the published current and timing.",
        compute: || feels(&Hypothesis::new("thesis", "final-75um", true)),
    },
    Row {
        id: "fig-5.5-C-ours",
        says: "Both users felt and drew all four paths, mostly where they were.",
        assumed: "The default bench's thin wires after a hot pass; (5.2) at 1.2 A and the published timing.",
        compute: || feels(&Hypothesis::new("emulated", "loose-50um", true)),
    },
    Row {
        id: "fig-5.5-C-default",
        says: "Both users felt and drew all four paths, mostly where they were.",
        assumed: "The default bench and the default law, `inverse`, in place of the thesis's.",
        compute: inverse,
    },
    Row {
        id: "claim-5.5-breaks",
        says: "Breaks lie around the centre between wires, and at wires.",
        assumed: "Thin wires of the default bench, (5.2), guard only observing. Near is a quarter of the gap of 9.5 mm.",
        compute: breaks,
    },
    Row {
        id: "claim-5.5-contact",
        says: "Deviations and jumps are taken to come from wires that touch the skin unevenly, and otherwise as the finger moves.",
        assumed: "The default bench and law. Each wire draws anew, every half second, which part of its motion reaches the skin; ten fingers for each range.",
        compute: uneven,
    },
    Row {
        id: "claim-5.5-compliant",
        says: "A compliant thimble would make the contact regular, and so the felt paths.",
        assumed: "Regular contact; the thimble gives under each wire by itself. The law knows how far.",
        compute: compliant,
    },
];

/// The scenes of the figure's four paths.
const PATHS: [&str; 4] = [
    "sphere-along",
    "sphere-across",
    "sphere-diagonal",
    "sphere-circle",
];

/// A make and state of wires on a bench.
struct Hypothesis {
    bench: &'static str,
    wire: &'static str,
    passed: bool,
}

impl Hypothesis {
    const fn new(bench: &'static str, wire: &'static str, passed: bool) -> Self {
        Self {
            bench,
            wire,
            passed,
        }
    }

    /// A path by (5.2) with the published timing.
    fn setup(&self, scene: &str) -> Result<Setup, Failure> {
        let mut overrides = Overrides::default();
        let by = "hil reproduce";
        overrides.scene(by, "illusion.model", "phantom");
        overrides.scene(by, "illusion.tau_d_ms", 35.0);
        overrides.bench(by, "wire.kind", self.wire);
        overrides.bench(by, "drive.soa_ms", 58.5);
        overrides.bench(by, "drive.hot_pass", self.passed);
        Ok(Setup::load(scene, self.bench)?.with(&overrides)?)
    }
}

/// Onsets of a run, those that are felt, and their median level, dB.
fn felt_onsets(outcome: &Outcome) -> (u64, u64, f64) {
    let onsets = &outcome.summary.onsets;
    let level = outcome
        .summary
        .felt
        .level_db
        .map_or(f64::NEG_INFINITY, |l| l.median);
    (onsets.meant, onsets.felt.unwrap_or(0), level)
}

/// Felt shares and levels of four setups.
fn all(
    setups: impl Iterator<Item = Result<Setup, Failure>>,
) -> Result<Vec<(u64, u64, f64)>, Failure> {
    setups
        .map(|setup| Ok(felt_onsets(&run(&setup?, &Input::Scene, 1)?)))
        .collect()
}

/// Shares felt and median levels in words, path by path.
fn told(found: &[(u64, u64, f64)]) -> String {
    let each = found.iter().map(|(meant, felt, level)| {
        let share = 100.0 * *felt as f64 / (*meant).max(1) as f64;
        format!("{share:.0} % ({level:+.1} dB)")
    });
    each.collect::<Vec<_>>().join(", ")
}

fn values(found: &[(u64, u64, f64)]) -> Value {
    let each = found
        .iter()
        .map(|(meant, felt, level)| json!({ "onsets": meant, "felt": felt, "level_db": level }));
    each.collect()
}

/// Decibels that the weakest path's median onset is short of the threshold: a wire that gave them would make the thesis right.
fn missing(found: &[(u64, u64, f64)]) -> f64 {
    found.iter().map(|(_, _, level)| -level).fold(0.0, f64::max)
}

fn answer(guarded: &[(u64, u64, f64)], free: &[(u64, u64, f64)]) -> Answer {
    let short = missing(free);
    let needs = match short > 0.0 {
        true => format!(
            "For the thesis to be right such wires must be felt {short:.1} dB more strongly on the weakest path."
        ),
        false => "Half of the onsets of every path are felt.".to_owned(),
    };
    Answer::new(
        Mark::Unknown(
            "people felt them; the wire's stroke, its state and the skin under it are not measured"
                .into(),
        ),
        format!(
            "Along, across, diagonal, circle: the typical person feels {} of the onsets with the guard, {} without. {needs}",
            told(guarded),
            told(free)
        ),
        json!({ "paths": PATHS, "guarded": values(guarded), "observed": values(free), "missing_db": short }),
    )
}

/// The four runs with the guard and without it.
fn guarded_and_free(setup: impl Fn(&str) -> Result<Setup, Failure>) -> Result<Answer, Failure> {
    let guarded = all(PATHS.iter().map(|scene| setup(scene)))?;
    let free = all(PATHS.iter().map(|scene| Ok(setup(scene)?.observed()?)))?;
    Ok(answer(&guarded, &free))
}

fn feels(hypothesis: &Hypothesis) -> Result<Answer, Failure> {
    guarded_and_free(|scene| hypothesis.setup(scene))
}

fn inverse() -> Result<Answer, Failure> {
    guarded_and_free(|scene| Ok(Setup::load(scene, "emulated")?))
}

/// The four runs on the default bench with the default law.
fn runs() -> Result<Vec<Outcome>, Failure> {
    PATHS
        .iter()
        .map(|scene| setups::played(&Setup::load(scene, "emulated")?))
        .collect()
}

fn contacts() -> Result<Answer, Failure> {
    let runs = runs()?;
    let errors = runs.iter().map(|run| run.summary.path_error_mm);
    let found: Vec<f64> = errors
        .map(|e| e.map_or(f64::INFINITY, |e| e.rmse))
        .collect();
    let words: Vec<String> = found.iter().map(|mm| format!("{mm:.2}")).collect();
    let words = words.join(", ");
    let most = found.iter().copied().fold(0.0, f64::max);
    Ok(Answer::new(
        Mark::new(most <= 0.47, || {
            format!("paths that keep to the edge are the worst: {words} mm")
        }),
        format!("{words} mm RMSE along, across, diagonal, in a circle."),
        json!({ "paths": PATHS, "rmse_mm": found }),
    ))
}

fn taxels() -> Result<Answer, Failure> {
    let count = |outcome: &Outcome| {
        let frames = outcome.trace.each::<event::Frame>();
        frames.map(|frame| frame.in_contact).max().unwrap_or(0)
    };
    let found: Vec<u16> = runs()?.iter().map(count).collect();
    let mut sweep = Vec::new();
    for margin in [0.0, 5.0, 10.0, 20.0, 30.0] {
        let setup = setups::changed("sphere-along", |scene| scene.threshold_margin = margin)?;
        sweep.push((margin, count(&setups::played(&setup)?)));
    }
    let told: Vec<String> = sweep
        .iter()
        .map(|(m, n)| format!("{m} counts: {n}"))
        .collect();
    let most = found.iter().copied().max().unwrap_or(0);
    Ok(Answer::new(
        Mark::new(most == 12, || {
            format!("the margin over (4.3), along: {}", told.join(", "))
        }),
        format!("At most {found:?} taxels along, across, diagonal, in a circle."),
        json!({ "paths": PATHS, "most": found, "margins": sweep.iter().map(|s| s.0).collect::<Vec<_>>(),
            "sweep": sweep.iter().map(|s| s.1).collect::<Vec<_>>() }),
    ))
}

fn speed() -> Result<Answer, Failure> {
    let slow = runs()?
        .iter()
        .filter(|run| setups::hertz(run) < 1000.0)
        .count();
    Ok(Answer::new(
        match slow {
            0 => Mark::Agrees,
            _ => Mark::Unexplained,
        },
        format!(
            "{} of four paths are faster than ten times that rate.",
            4 - slow
        ),
        json!({ "slow_paths": slow }),
    ))
}

/// Distance from a wire that counts as near it, mm.
const NEAR_MM: f64 = 9.5 / 4.0;

fn breaks() -> Result<Answer, Failure> {
    let hypothesis = Hypothesis::new("emulated", "loose-50um", true);
    // Onsets and those that are not felt, near a wire and between wires.
    let mut counts = [[0_u32; 2]; 2];
    for scene in PATHS {
        let outcome = run(&hypothesis.setup(scene)?.observed()?, &Input::Scene, 1)?;
        let wires = &outcome.trace.header.wires;
        let felt = outcome.trace.each::<event::Felt>();
        for event::Felt { target, met, .. } in felt.filter(|felt| felt.inside) {
            let near = wires.iter().any(|wire| {
                let (dx, dy) = (wire.place.x - target.x, wire.place.y - target.y);
                f64::from(dx).hypot(f64::from(dy)) * 1e-3 <= NEAR_MM
            });
            let [onsets, unfelt] = &mut counts[usize::from(!near)];
            *onsets += 1;
            *unfelt += u32::from(!met.is_some_and(|met| met.is_felt()));
        }
    }
    let share = |[onsets, unfelt]: [u32; 2]| 100.0 * f64::from(unfelt) / f64::from(onsets.max(1));
    let [near, between] = counts.map(share);
    Ok(Answer::new(
        Mark::new(between > near, || "breaks are as many near a wire".into()),
        format!(
            "{between:.0} % of {} onsets between wires are not felt, {near:.0} % of {} near a wire.",
            counts[1][0], counts[0][0]
        ),
        json!({ "near": counts[0], "between": counts[1] }),
    ))
}

/// Errors of four paths together.
#[derive(Default)]
struct Together {
    /// Sum of squared errors over felt onsets inside the wires, mm2, and their number.
    square: f64,
    onsets: u64,
    jumps: u64,
    breaks: u64,
    levels_db: Vec<f64>,
}

impl Together {
    fn add(&mut self, outcome: &Outcome) {
        let felt = &outcome.summary.felt;
        if let Some(error) = felt.error_energy_mm {
            self.square += error.rmse * error.rmse * felt.onsets_inside as f64;
            self.onsets += felt.onsets_inside;
        }
        self.jumps += felt.jumps.unwrap_or(0);
        self.breaks += felt.breaks.unwrap_or(0);
        self.levels_db
            .extend(felt.level_db.map(|level| level.median));
    }

    fn rmse_mm(&self) -> f64 {
        (self.square / self.onsets.max(1) as f64).sqrt()
    }
}

/// The four paths with a change of scene and bench.
fn paths(change: impl Fn(&mut Scene, &mut Bench)) -> Result<Together, Failure> {
    let mut found = Together::default();
    for scene in PATHS {
        let mut setup = Setup::load(scene, "emulated")?;
        change(&mut setup.scene.value, &mut setup.bench.value);
        let setup = Setup::join(setup.scene, setup.bench)?;
        found.add(&run(&setup, &Input::Scene, 1)?);
    }
    Ok(found)
}

/// Seats of eight wires under a finger that moves: each has another part, from `least` to 1, every half second.
fn wiggling(least: f64, finger: u64) -> Vec<Seat> {
    let seat = |wire: usize| {
        let mut draws = RandomStream::new(finger, &format!("contact of wire {wire}"));
        let point = |n: u32| [f64::from(n) * 0.5, least + (1.0 - least) * draws.uniform()];
        Seat {
            wire,
            points_s_part: (0..=20).map(point).collect(),
        }
    };
    (0..8).map(seat).collect()
}

/// Fingers of each range of contact.
const FINGERS: u64 = 10;

fn uneven() -> Result<Answer, Failure> {
    let even = paths(|_, _| ())?;
    let (mut told, mut rows) = (Vec::new(), Vec::new());
    for least in [0.7, 0.4, 0.1] {
        let fingers = (1..=FINGERS).map(|finger| {
            let found = paths(|scene, _| scene.seats = wiggling(least, finger))?;
            Ok((found.rmse_mm(), found.jumps, found.breaks))
        });
        let mut fingers: Vec<(f64, u64, u64)> = fingers.collect::<Result<_, Failure>>()?;
        fingers.sort_by(|a, b| a.0.total_cmp(&b.0));
        let count = |of: fn(&(f64, u64, u64)) -> u64| {
            fingers.iter().map(of).sum::<u64>() as f64 / FINGERS as f64
        };
        let (first, last) = (fingers[0].0, fingers[fingers.len() - 1].0);
        told.push(format!(
            "parts from {least} to 1 {first:.2} to {last:.2} mm, {:.1} jumps and {:.1} breaks",
            count(|f| f.1),
            count(|f| f.2)
        ));
        let rmse: Vec<f64> = fingers.iter().map(|f| f.0).collect();
        rows.push(json!({ "least": least, "rmse_mm": rmse, "jumps": count(|f| f.1), "breaks": count(|f| f.2) }));
    }
    Ok(Answer::new(
        Mark::Unknown("the part of a wire's motion that reached the skin was not measured".into()),
        format!(
            "Over four paths, even contact gives {:.2} mm RMSE, {} jumps and {} breaks; {}.",
            even.rmse_mm(),
            even.jumps,
            even.breaks,
            told.join("; ")
        ),
        json!({ "even_rmse_mm": even.rmse_mm(), "even_jumps": even.jumps, "even_breaks": even.breaks, "fingers": rows }),
    ))
}

fn compliant() -> Result<Answer, Failure> {
    let (mut told, mut rows) = (Vec::new(), Vec::new());
    for um_per_mn in [0.0, 1.0, 3.0, 10.0] {
        let found = paths(|_, bench| bench.mount.compliance_um_per_mn = um_per_mn)?;
        let levels_db = found.levels_db.iter().copied();
        let level_db = levels_db.fold(f64::INFINITY, f64::min);
        told.push(format!(
            "{um_per_mn} um/mN {:.2} mm RMSE, {level_db:+.1} dB on the weakest path, {} breaks",
            found.rmse_mm(),
            found.breaks
        ));
        rows.push(json!({ "um_per_mn": um_per_mn, "rmse_mm": found.rmse_mm(), "level_db": level_db, "breaks": found.breaks }));
    }
    Ok(Answer::new(
        Mark::Unknown("the thesis proposes it and did not build it".into()),
        format!("A thimble that gives way by {}.", told.join("; ")),
        json!({ "thimbles": rows }),
    ))
}
