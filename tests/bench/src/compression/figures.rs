//! The thesis's figures 4.5 to 4.7, from emulated scenes and from a recording: where contacts are found for K_C of 1 to
//! 16, and how fast, beside the sensor's rate.

use std::path::{Path, PathBuf};

use palpate_files::{DRIFT_S, Setup, THRESHOLD_FLOOR, ThresholdFrom, Timing};
use palpate_hil::reproduce::setups::{CLUSTERS, THINGS, changed, grasp, grip, roll, run, span};
use palpate_live::recording::{Reading, recorded};
use palpate_records::trace::{Event, event};
use palpate_run::{Failure, Input, Outcome};

use super::panels;
use crate::findings::Findings;
use crate::plot::{Axis, Mark, Plot, Series};
use crate::scenes::{frame_us, skin};

/// Things that figure 4.7 shows: the first.
const SHOWN: usize = 4;
/// Scans per second of an emulated board.
const SENSOR_HZ: f64 = 100.0;
/// Scans per second of a hand whose 15 boards wait for one another on one bus, as in the thesis, about.
const HAND_HZ: f64 = 30.0;
/// Rows per second of the recordings, about.
const RECORDED_HZ: f64 = 40.0;

/// All figures.
///
/// # Errors
/// A scene that does not run.
pub(super) fn measure(findings: &mut Findings) -> Result<(), Failure> {
    sphere(findings)?;
    hand(findings)?;
    recording(findings)
}

/// Results of one scene, with more and more clusters.
#[derive(Default)]
struct Sweep {
    places: Vec<Series>,
    speeds: Vec<(f64, f64)>,
    /// Every run with its K_C.
    runs: Vec<(u32, Outcome)>,
}

impl Sweep {
    /// One more run: where its contacts are at times of `when`, and how fast it was.
    fn add(
        &mut self,
        (findings, case): (&mut Findings, &str),
        kc: u32,
        outcome: Outcome,
        seen: &Seen<'_>,
    ) {
        let (frames, us) = (f64::from(outcome.summary.frames.max(1)), frame_us(&outcome));
        let error = (
            outcome.summary.contacts as f64 / frames,
            "contacts per frame",
        );
        findings.row(case, &format!("K={kc}"), error, us);
        let name = format!("K_C = {kc}");
        let places = Series::new(name, Mark::Scatter, seen.places(&outcome));
        // The finest first, so that the coarser ones lie over it.
        self.places.insert(0, places);
        self.speeds.push((f64::from(kc), 1e6 / us));
        self.runs.push((kc, outcome));
    }
}

/// Choice of the contacts that are drawn: their time span, and the origins of their modules.
struct Seen<'a> {
    /// Origin of each module, mm; without, all are drawn in their module's plane.
    origins: &'a [(f64, f64)],
    /// Times, microseconds.
    span: std::ops::Range<u64>,
}

impl Seen<'_> {
    fn places(&self, outcome: &Outcome) -> Vec<(f64, f64)> {
        let place = |event: &Event| match event {
            Event::Contact(event::Contact {
                t_us,
                module,
                place,
                ..
            }) if self.span.contains(t_us) => {
                let origin = self.origins.get(usize::from(*module));
                let (x, y) = origin.copied().unwrap_or_default();
                Some((x + f64::from(place.x) * 1e-3, y + f64::from(place.y) * 1e-3))
            }
            _ => None,
        };
        outcome.trace.events.iter().filter_map(place).collect()
    }
}

/// Contacts of all frames in their module's plane.
const ALL: Seen<'_> = Seen {
    origins: &[],
    span: 0..u64::MAX,
};

fn map(findings: &mut Findings, name: &str, title: &str, words: &str, series: Vec<Series>) {
    let plot = Plot::of_plane(series);
    findings.figures.push(plot.figure(name, title, words));
}

fn speeds(findings: &mut Findings, name: &str, title: &str, rate: f64, mut series: Vec<Series>) {
    let sensor = CLUSTERS.iter().map(|k| (f64::from(*k), rate)).collect();
    series.push(Series::new("the sensor", Mark::Line, sensor));
    let plot = Plot {
        x: Axis::linear("most contacts, K_C").span(0.0, 17.0),
        y: Axis::decades("frames per second [Hz]"),
        series,
    };
    let words = "Frames per second of the whole loop, CAN frames to actuators, one core.";
    findings.figures.push(plot.figure(name, title, words));
}

/// Figures 4.5 and 4.6: a sphere that rolls on one module.
fn sphere(findings: &mut Findings) -> Result<(), Failure> {
    let mut sweep = Sweep::default();
    let case = "figure 4.5 sphere";
    for kc in CLUSTERS {
        let setup = roll(kc, 0.5, 0.5)?;
        sweep.add((findings, case), kc, run(&setup, &Input::Scene)?, &ALL);
    }
    let title = "Figure 4.5: sphere on 4x4";
    let words = "Contacts of all frames while a sphere of 19.45 mm rolls over the module from bottom to top.";
    map(findings, "figure-4-5", title, words, sweep.places);
    let setup = roll(1, 0.5, 0.5)?;
    one_module(
        findings,
        "",
        "",
        &panels::kept(&setup, &Input::Scene)?,
        &sweep.runs,
    );
    let fast = Series::new("4x4, sphere", Mark::Swept, sweep.speeds);
    let title = "Figure 4.6: speed on one module";
    speeds(findings, "figure-4-6", title, SENSOR_HZ, vec![fast]);
    Ok(())
}

/// Figure 4.7: a hand that grasps four things of different size and hardness.
fn hand(findings: &mut Findings) -> Result<(), Failure> {
    let layout = skin("allegro")?;
    let modules = layout.modules().iter().map(|m| m.origin());
    let origins: Vec<_> = modules.map(|o| (f64::from(o.x), f64::from(o.y))).collect();
    // One frame in the middle of the grasp.
    let seen = Seen {
        origins: &origins,
        span: 3_200_000..3_233_000,
    };
    let mut fast = Vec::new();
    for &(object, diameter, weight) in &THINGS[..SHOWN] {
        let force = grip(weight);
        let mut sweep = Sweep::default();
        let case = format!("figure 4.7 {object}");
        for kc in CLUSTERS {
            let setup = changed("allegro-one-bus", |scene| {
                scene.compression.kc = kc;
                grasp(scene, diameter, force);
            })?;
            sweep.add((findings, &case), kc, run(&setup, &Input::Scene)?, &seen);
        }
        let setup = changed("allegro-one-bus", |scene| {
            grasp(scene, diameter, force);
        })?;
        let outcome = panels::kept(&setup, &Input::Scene)?;
        let named = |panel: &str| format!("figure-4-7-{}-{panel}", object.replace(' ', "-"));
        let title = format!("Figure 4.7, top: {object}");
        panels::histogram(findings, &named("histogram"), &title, &outcome);
        let title = format!("Figure 4.7, bottom: {object}");
        panels::course(findings, &named("course"), &title, &sweep.runs);
        if let Some((least, most)) = sweep.runs.last().map(|(_, last)| span(last)) {
            findings.words.push(format!(
                "figure 4.7, {object}: {least} to {most} taxels in contact while it is held (thesis: 75 to 125)"
            ));
        }
        let name = format!("figure-4-7-{}", object.replace(' ', "-"));
        let title = format!("Figure 4.7: hand, {object}");
        let words =
            "Contacts of one frame over the whole hand, modules where the layout puts them.";
        map(findings, &name, &title, words, sweep.places);
        fast.push(Series::new(object, Mark::Swept, sweep.speeds));
    }
    let title = "Figure 4.7: speed on the hand";
    speeds(findings, "figure-4-7-speed", title, HAND_HZ, fast);
    Ok(())
}

/// The first trial of the grasp recordings, where they are at hand.
fn trial() -> Option<PathBuf> {
    let data = std::env::var_os("PALPATE_DATA").map_or_else(
        || Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/data"),
        PathBuf::from,
    );
    let entries = std::fs::read_dir(data.join("uskin_grasp")).ok()?;
    let trials = entries.flatten().map(|e| e.path().join("xela_sensor1.csv"));
    trials.filter(|file| file.is_file()).min()
}

/// Setup of a run of a real module's recording.
fn recorded_setup(kc: u32) -> Result<Setup, Failure> {
    changed("sphere-circle", |scene| {
        scene.compression.kc = kc;
        scene.touches.clear();
        scene.threshold = ThresholdFrom::PerTaxel;
        scene.threshold_margin = THRESHOLD_FLOOR;
        scene.drift_s = Some(DRIFT_S);
        scene.name = "recording".into();
    })
}

/// The panels of figures 4.5 and 4.6 but the places of all contacts.
fn one_module(
    findings: &mut Findings,
    ending: &str,
    of: &str,
    outcome: &Outcome,
    clusters: &[(u32, Outcome)],
) {
    let named = |panel: &str| format!("figure-{panel}{ending}");
    let titled = |panel: &str| format!("Figure {panel}{of}");
    panels::edges(findings, &named("4-5-a"), &titled("4.5-A, edges"), outcome);
    panels::histogram(findings, &named("4-5-b"), &titled("4.5-B"), outcome);
    panels::raw(findings, &named("4-5-c"), &titled("4.5-C"), outcome);
    let (name, title) = (named("4-6-a"), titled("4.6-A and C"));
    panels::fullest(findings, &name, &title, (outcome, clusters));
}

/// Rows of our own header that come at this rate, Hz.
fn at_rate(hz: f64) -> Reading {
    let timing = Timing {
        rate_hz: Some(hz),
        ..Timing::default()
    };
    Reading {
        timing,
        ..Reading::default()
    }
}

/// Adds the figures of a recording by a real finger.
fn recording(findings: &mut Findings) -> Result<(), Failure> {
    let Some(trial) = trial() else {
        let words = "skipped: no recordings, so no figures from them";
        findings.words.push(words.into());
        return Ok(());
    };
    let paths = [trial];
    let mut sweep = Sweep::default();
    let case = "figure 4.5 recorded grasp";
    for kc in CLUSTERS {
        let setup = recorded_setup(kc)?;
        let (input, _) = recorded(&paths, &setup.sensor.value, &at_rate(RECORDED_HZ))?;
        sweep.add((findings, case), kc, run(&setup, &input)?, &ALL);
    }
    let title = "Figure 4.5 from a recording: a gripper's finger on a box";
    let words = "Contacts of all frames of one trial of the uSkin grasp recordings.";
    map(findings, "figure-4-5-recorded", title, words, sweep.places);
    let setup = recorded_setup(1)?;
    let (input, _) = recorded(&paths, &setup.sensor.value, &at_rate(RECORDED_HZ))?;
    let outcome = panels::kept(&setup, &input)?;
    one_module(findings, "-recorded", ", recorded", &outcome, &sweep.runs);
    let fast = Series::new("recorded 4x4", Mark::Swept, sweep.speeds);
    let (name, title) = ("figure-4-6-recorded", "Figure 4.6 from a recording");
    speeds(findings, name, title, RECORDED_HZ, vec![fast]);
    Ok(())
}
