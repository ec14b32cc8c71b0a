//! The thesis's figures 4.5 to 4.7 over again, from emulated scenes and from real recordings: where contacts are
//! found for K_C of 1 to 16, and how fast, beside the sensor's rate.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use palpate_records::trace::Event;

use super::frames::skin;
use crate::bench::plot::{Axis, Mark, Plot, Series};
use crate::bench::{Findings, Row};
use crate::failure::Failure;
use crate::run::{Input, Outcome, run};
use palpate_files::{
    DRIFT_S, Force, Path as TouchPath, PathKind, Scene, Setup, THRESHOLD_FLOOR, ThresholdRule,
    Touch, load_bench, load_scene,
};

const CLUSTERS: [u32; 5] = [1, 2, 4, 8, 16];
/// Rows a second of the recordings, about.
const RECORDED_HZ: f64 = 40.0;

/// Things to grasp: name, diameter where a finger meets it, mm, and force a module, N (hard things press harder).
/// Between them 75 to 125 taxels are in contact, as in the thesis.
const OBJECTS: [(&str, f64, f64); 4] = [
    ("soft ball", 30.0, 0.35),
    ("hard ball", 30.0, 0.5),
    ("soft bottle", 60.0, 0.35),
    ("hard bottle", 60.0, 0.48),
];

/// All figures.
///
/// # Errors
/// A scene that does not run.
pub(super) fn measure(findings: &mut Findings) -> Result<(), Failure> {
    sphere(findings)?;
    hand(findings)?;
    recordings(findings)
}

/// A scene with another K_C and ten static levels.
fn with(name: &str, kc: u32, change: impl FnOnce(&mut Scene)) -> Result<Setup, Failure> {
    let mut scene = load_scene(name)?;
    scene.value.compression.kc = kc;
    change(&mut scene.value);
    Ok(Setup::join(scene, load_bench("emulated")?)?)
}

/// Every contact's place, mm: in its module's plane, or the skin's if `origins` are given.
fn places(
    outcome: &Outcome,
    origins: &[(f64, f64)],
    when: impl Fn(u64) -> bool,
) -> Vec<(f64, f64)> {
    let place = |event: &Event| match event {
        Event::Contact {
            t_us,
            module,
            place,
            ..
        } if when(*t_us) => {
            let origin = origins
                .get(usize::from(*module))
                .copied()
                .unwrap_or_default();
            Some((
                origin.0 + f64::from(place.x) * 1e-3,
                origin.1 + f64::from(place.y) * 1e-3,
            ))
        }
        _ => None,
    };
    outcome.trace.events.iter().filter_map(place).collect()
}

/// Fewest and most taxels in contact in a frame within `span`, microseconds.
fn held(outcome: &Outcome, span: std::ops::Range<u64>) -> (u32, u32) {
    let mut frames = BTreeMap::new();
    for event in &outcome.trace.events {
        if let Event::Contact { t_us, members, .. } = event
            && span.contains(t_us)
        {
            *frames.entry(*t_us).or_insert(0) += *members;
        }
    }
    let counts = || frames.values().copied();
    (counts().min().unwrap_or(0), counts().max().unwrap_or(0))
}

/// Frames a second that the loop could have done.
fn speed(outcome: &Outcome) -> f64 {
    let median = outcome.summary.frame_us.map_or(f64::NAN, |t| t.median);
    1e6 / median
}

fn row(findings: &mut Findings, case: &str, kc: u32, outcome: &Outcome) {
    let frames = f64::from(outcome.summary.frames.max(1));
    findings.rows.push(Row {
        family: "compression",
        case: case.into(),
        method: format!("K={kc}"),
        error: outcome.summary.contacts as f64 / frames,
        error_unit: "contacts a frame",
        median_us: 1e6 / speed(outcome),
        peer: false,
    });
}

fn map(name: &str, title: String, words: &str, series: Vec<Series>) -> Plot {
    let axis = |label: &str| Axis {
        label: label.into(),
        log: false,
    };
    Plot {
        name: name.into(),
        title,
        words: words.into(),
        x: axis("x [mm]"),
        y: axis("y [mm]"),
        series,
    }
}

fn speeds(name: &str, title: &str, rate: f64, series: Vec<(String, Vec<(f64, f64)>)>) -> Plot {
    let axis = |label: &str| Axis {
        label: label.into(),
        log: true,
    };
    let mut series: Vec<_> = series
        .into_iter()
        .map(|(name, points)| Series {
            name,
            points,
            mark: Mark::Swept,
        })
        .collect();
    series.push(Series {
        name: "the sensor".into(),
        points: CLUSTERS.iter().map(|k| (f64::from(*k), rate)).collect(),
        mark: Mark::Line,
    });
    Plot {
        name: name.into(),
        title: title.into(),
        words: "Frames a second of the whole loop, CAN frames to actuators, one core.".into(),
        x: axis("K_C"),
        y: axis("frames a second [Hz]"),
        series,
    }
}

fn scatter(name: String, points: Vec<(f64, f64)>) -> Series {
    Series {
        name,
        points,
        mark: Mark::Scatter,
    }
}

/// Figures 4.5 and 4.6: a sphere that rolls on one module.
fn sphere(findings: &mut Findings) -> Result<(), Failure> {
    let (mut found, mut fast) = (Vec::new(), Vec::new());
    for kc in CLUSTERS {
        let outcome = run(&with("sphere-circle", kc, |_| ())?, &Input::Scene, 1)?;
        found.push(scatter(
            format!("K_C = {kc}"),
            places(&outcome, &[], |_| true),
        ));
        fast.push((f64::from(kc), speed(&outcome)));
        row(findings, "figure 4.5 sphere", kc, &outcome);
    }
    let words =
        "Contacts of all frames while a sphere of 19.45 mm rolls in a circle over the module.";
    for series in found.into_iter().rev() {
        let name = format!(
            "figure-4-5-{}",
            series.name.to_lowercase().replace("_c = ", "")
        );
        let title = format!("Figure 4.5: sphere on 4x4, {}", series.name);
        findings.plots.push(map(&name, title, words, vec![series]));
    }
    let fast = vec![("4x4, sphere".into(), fast)];
    findings.plots.push(speeds(
        "figure-4-6",
        "Figure 4.6: speed on one module",
        100.0,
        fast,
    ));
    Ok(())
}

/// A grasp: every module of a hand is pressed by the same thing, each a little elsewhere.
fn grasp(scene: &mut Scene, modules: usize, diameter_mm: f64, force: f64) {
    scene.length_s = 3.0;
    let touch = |module: usize| {
        let turn = 2.4 * module as f64;
        Touch {
            module,
            diameter_mm,
            start_s: 0.8,
            end_s: 2.9,
            ramp_s: 0.2,
            path: TouchPath {
                kind: PathKind::Circle,
                points_mm: Vec::new(),
                centre_mm: Some([2.0 * libm::cos(turn), 2.0 * libm::sin(turn)]),
                radius_mm: Some(1.5),
                period_s: Some(2.0),
            },
            force_n: Force {
                mean: force * (0.8 + 0.4 * (module % 4) as f64 / 3.0),
                amplitude: 0.1 * force,
                period_s: 1.1,
            },
        }
    };
    scene.touches = (0..modules).map(touch).collect();
}

/// Figure 4.7: a hand that grasps four things of different size and hardness.
fn hand(findings: &mut Findings) -> Result<(), Failure> {
    let layout = skin("allegro")?;
    let origins: Vec<(f64, f64)> = layout
        .modules()
        .iter()
        .map(|m| (f64::from(m.origin().x), f64::from(m.origin().y)))
        .collect();
    let mut fast = Vec::new();
    for (object, diameter, force) in OBJECTS {
        let mut speeds = Vec::new();
        let mut found = Vec::new();
        for kc in CLUSTERS {
            let setup = with("allegro-four-buses", kc, |scene| {
                grasp(scene, layout.modules().len(), diameter, force);
            })?;
            let outcome = run(&setup, &Input::Scene, 1)?;
            // One frame in the middle of the grasp.
            let instant = |t: u64| (1_800_000..1_810_000).contains(&t);
            found.push(scatter(
                format!("K_C = {kc}"),
                places(&outcome, &origins, instant),
            ));
            speeds.push((f64::from(kc), speed(&outcome)));
            row(findings, &format!("figure 4.7 {object}"), kc, &outcome);
            if kc == 1 {
                let (least, most) = held(&outcome, 1_200_000..2_600_000);
                findings.words.push(format!(
                    "figure 4.7, {object}: {least} to {most} taxels in contact while it is held (thesis: 75 to 125)"
                ));
            }
        }
        // The finest first, so that the coarser ones lie over it.
        found.reverse();
        let name = format!("figure-4-7-{}", object.replace(' ', "-"));
        let title = format!("Figure 4.7: hand, {object}");
        let words =
            "Contacts of one frame over the whole hand, modules where the layout puts them.";
        findings.plots.push(map(&name, title, words, found));
        fast.push((object.to_owned(), speeds));
    }
    findings.plots.push(speeds(
        "figure-4-7-speed",
        "Figure 4.7: speed on the hand",
        100.0,
        fast,
    ));
    Ok(())
}

/// The trials of the grasp recordings, where they are at hand.
fn trials() -> Vec<PathBuf> {
    let data = std::env::var_os("PALPATE_DATA").map_or_else(
        || Path::new(env!("CARGO_MANIFEST_DIR")).join("../../shared/data"),
        PathBuf::from,
    );
    let entries = std::fs::read_dir(data.join("uskin_grasp"))
        .into_iter()
        .flatten();
    let mut trials: Vec<_> = entries
        .flatten()
        .map(|e| e.path().join("xela_sensor1.csv"))
        .collect();
    trials.retain(|file| file.is_file());
    trials.sort();
    trials
}

/// The same from real fingers.
fn recordings(findings: &mut Findings) -> Result<(), Failure> {
    let trials = trials();
    let Some(trial) = trials.first() else {
        findings
            .words
            .push("skipped: no recordings, so no figures from them".into());
        return Ok(());
    };
    let (mut fast, mut found) = (Vec::new(), Vec::new());
    for kc in CLUSTERS {
        let setup = with("sphere-circle", kc, |scene| {
            scene.touches.clear();
            scene.threshold = ThresholdRule::PerTaxel;
            scene.threshold_margin = THRESHOLD_FLOOR;
            scene.drift_s = Some(DRIFT_S);
            scene.name = "recording".into();
        })?;
        let input = Input::Replay {
            paths: vec![trial.clone()],
            rate_hz: Some(RECORDED_HZ),
        };
        let outcome = run(&setup, &input, 1)?;
        found.push(scatter(
            format!("K_C = {kc}"),
            places(&outcome, &[], |_| true),
        ));
        fast.push((f64::from(kc), speed(&outcome)));
        row(findings, "figure 4.5 recorded grasp", kc, &outcome);
    }
    found.reverse();
    let title = "Figure 4.5 from a recording: a gripper's finger on a box".to_owned();
    let words = "Contacts of all frames of one trial of the uSkin grasp recordings.";
    findings
        .plots
        .push(map("figure-4-5-recorded", title, words, found));
    let fast = vec![("recorded 4x4".into(), fast)];
    let plot = speeds(
        "figure-4-6-recorded",
        "Figure 4.6 from a recording",
        RECORDED_HZ,
        fast,
    );
    findings.plots.push(plot);
    Ok(())
}
