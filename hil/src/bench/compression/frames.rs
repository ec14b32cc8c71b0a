//! Whole frames of skins of every size: from raw counts to contacts, and how the time grows.

use std::time::Duration;

use palpate_core::contact::{Compressor, Scope, Settings};
use palpate_core::skin::{Layout, Module};

use super::presses::{Presses, ROUND, scans};
use crate::bench::plot::{Axis, Mark, Plot, Series};
use crate::bench::timing::Race;
use crate::bench::{Findings, Row};
use crate::failure::Failure;
use crate::{parallel, plan};
use palpate_files::{LayoutFile, load_layout};

const SAMPLES: usize = 200;
const BUDGET: Duration = Duration::from_millis(2000);

/// A skin, what touches it, and how its contacts are found.
struct Case<'a> {
    name: &'a str,
    layout: &'a Layout,
    presses: Option<Presses>,
    clusters: u16,
    scope: Scope,
    /// Most iterations a frame.
    iterations: u32,
    /// Frames made; they are gone through again and again.
    frames: usize,
    /// Whether one frame comes over and over.
    repeated: bool,
    /// Whether modules are worked on by all cores.
    parallel: bool,
}

/// A skin by its name.
///
/// # Errors
/// No such sensor layout.
pub fn skin(name: &str) -> Result<Layout, Failure> {
    match load_layout(name)?.value {
        LayoutFile::Sensor(file) => plan::layout(&file),
        LayoutFile::Display(_) => Err(Failure::Input(format!("{name}: expected a sensor layout"))),
    }
}

/// Median time of a frame, microseconds.
fn time(case: &Case<'_>) -> Result<f64, Failure> {
    let (mut initialiser, scans) = scans(case.layout, case.presses, case.frames)?;
    let settings = Settings {
        clusters: case.clusters,
        scope: case.scope,
        exponent: 2.0,
        max_iterations: case.iterations,
        ..Settings::default()
    };
    let failed = |e: &dyn std::fmt::Display| Failure::Input(format!("{}: {e}", case.name));
    let mut compressor = Compressor::new(case.layout, settings).map_err(|e| failed(&e))?;
    let mut frame = initialiser.frame(case.layout);
    let wanted = match case.presses {
        None => 0,
        Some(Presses::EveryModule(n) | Presses::Skin { taxels: n, .. }) => n,
    };
    let (mut at, mut failure) = (0, None);
    let mut race = Race::default();
    race.enter(|| {
        let scan = &scans[if case.repeated { 0 } else { at % scans.len() }];
        at += 1;
        let mut compress = || {
            if initialiser.advance(scan, &mut frame)? || !compressor.repeat() {
                if case.parallel {
                    parallel::compress(&mut compressor, &frame)?;
                } else {
                    compressor.compress(&frame)?;
                }
            }
            Ok(frame.contacts().len())
        };
        match compress() {
            Ok(n) if n == wanted => {}
            Ok(n) => failure = Some(format!("{n} taxels in contact, expected {wanted}")),
            Err::<_, palpate_core::skin::FrameError>(e) => failure = Some(e.to_string()),
        }
    });
    let samples = race.run(SAMPLES, BUDGET);
    match failure {
        Some(failure) => Err(failed(&failure)),
        None => Ok(samples[0].median()),
    }
}

/// Measures frames of the skins that are shipped, and grids from 16 taxels to a million.
///
/// # Errors
/// A skin that cannot be made.
pub fn measure(findings: &mut Findings) -> Result<(), Failure> {
    let [pad, hand, body, gel, million] =
        ["uskin-4x4", "allegro", "icub-body", "digit", "million"].map(skin);
    let (pad, hand, body, gel, million) = (pad?, hand?, body?, gel?, million?);
    let case = |name, layout, presses, clusters| Case {
        name,
        layout,
        presses,
        clusters,
        scope: Scope::Module,
        iterations: Settings::default().max_iterations,
        frames: ROUND,
        repeated: false,
        parallel: false,
    };
    let (twelve, grasp) = (
        Some(Presses::EveryModule(12)),
        Some(Presses::EveryModule(125)),
    );
    let touched = |presses, taxels| Some(Presses::Skin { presses, taxels });
    let large = |name, layout, presses, scope, parallel| Case {
        scope,
        parallel,
        iterations: 2,
        frames: 4,
        ..case(name, layout, presses, 16)
    };
    let cases = [
        case("frame 4x4, 12 in contact, K=1", &pad, twelve, 1),
        case("frame 4x4, 12 in contact, K=4", &pad, twelve, 4),
        case("frame hand, 125 in contact, K=4 a module", &hand, grasp, 4),
        Case {
            // A scan was just received: it is not far from the processor, as those of a whole round would be.
            frames: 16,
            ..case("frame hand, idle, fresh noise", &hand, None, 4)
        },
        Case {
            repeated: true,
            ..case("frame hand, 125 in contact, repeated", &hand, grasp, 4)
        },
        Case {
            repeated: true,
            ..case("frame hand, idle, repeated", &hand, None, 4)
        },
        Case {
            scope: Scope::Skin,
            ..case(
                "frame iCub, 200 of 2040 in contact, K=8",
                &body,
                touched(8, 200),
                8,
            )
        },
        large(
            "frame DIGIT, all in contact, K=16, two iterations",
            &gel,
            touched(16, 307_200),
            Scope::Skin,
            false,
        ),
        large(
            "frame DIGIT, a tenth in contact, K=16, two iterations",
            &gel,
            touched(16, 30_720),
            Scope::Skin,
            false,
        ),
        large(
            "frame million, a tenth in contact, K=16 a module, two iterations",
            &million,
            touched(16, 100_000),
            Scope::Module,
            false,
        ),
        large(
            "frame million, a tenth in contact, K=16 a module, two iterations, all cores",
            &million,
            touched(16, 100_000),
            Scope::Module,
            true,
        ),
    ];
    for case in &cases {
        row(findings, case.name, time(case)?);
    }
    growth(findings)
}

fn row(findings: &mut Findings, case: &str, median_us: f64) {
    findings.rows.push(Row {
        family: "compression",
        case: case.into(),
        method: "default".into(),
        error: f64::NAN,
        error_unit: "",
        median_us,
        peer: false,
    });
}

/// Time against the number of taxels, half of them in contact.
fn growth(findings: &mut Findings) -> Result<(), Failure> {
    let mut series = Vec::new();
    for clusters in [1, 8] {
        let mut points = Vec::new();
        for side in [4, 8, 16, 32, 64, 128, 256, 512, 1000_u16] {
            let module = Module::grid("grid", side, side, 1.0);
            let layout = module.and_then(Layout::single);
            let layout = layout.map_err(|e| Failure::Input(format!("bench: {e}")))?;
            let taxels = usize::from(side) * usize::from(side);
            let name = format!("growth {taxels} taxels, K={clusters}");
            let us = time(&Case {
                name: &name,
                layout: &layout,
                presses: Some(Presses::Skin {
                    presses: 8,
                    taxels: taxels / 2,
                }),
                clusters,
                scope: Scope::Module,
                iterations: 2,
                frames: 4,
                repeated: false,
                parallel: false,
            })?;
            row(findings, &name, us);
            points.push((taxels as f64, us));
        }
        series.push(Series {
            name: format!("K = {clusters}"),
            points,
            mark: Mark::Ours,
        });
    }
    let axis = |label: &str| Axis {
        label: label.into(),
        log: true,
    };
    findings.plots.push(Plot {
        name: "growth".into(),
        title: "Time of a frame against the size of the skin".into(),
        words: "Half of the taxels in contact under eight presses, warm, two iterations, one core: raw counts to contacts.".into(),
        x: axis("taxels"),
        y: axis("median run time [\u{b5}s]"),
        series,
    });
    Ok(())
}
