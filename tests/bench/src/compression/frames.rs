//! Whole frames of skins of every size: from raw counts to contacts, and how the time grows.

use std::cell::Cell;
use std::time::Duration;

use palpate_core::contact::{Compressor, Scope, Settings};
use palpate_core::skin::{Layout, Module, Scan};
use palpate_core::units::{Duration as Span, Instant};

use palpate_run::Failure;
use rayon::prelude::*;

use crate::findings::{Findings, NO_ERROR};
use crate::plot::{Axis, Mark, Plot, Series};
use crate::presses::{Presses, ROUND, scans};
use crate::scenes::skin;
use crate::timing::Race;

const SAMPLES: usize = 200;
const BUDGET: Duration = Duration::from_millis(2000);

/// A skin, what touches it, and how its contacts are found.
#[derive(Clone, Copy)]
struct Case<'a> {
    name: &'a str,
    skin: &'a str,
    presses: Option<Presses>,
    clusters: u16,
    scope: Scope,
    /// Most iterations per frame, where not the program's own.
    iterations: Option<u32>,
    /// Frames made; they are gone through again and again.
    frames: usize,
    /// True if all cores work on modules.
    parallel: bool,
}

/// The hand at rest, with a scan of fresh noise.
const HAND: Case<'_> = Case {
    name: "frame hand, idle, fresh noise",
    skin: "allegro",
    presses: None,
    clusters: 4,
    scope: Scope::Module,
    iterations: None,
    // A scan was just received: it is not far from the processor, as those of a whole round would be.
    frames: 16,
    parallel: false,
};

/// A million taxels, on one core.
const MILLION: Case<'_> = Case {
    name: "frame million, a tenth in contact, K=16 a module, two iterations",
    skin: "million",
    presses: Some(Presses::Skin {
        presses: 16,
        taxels: 100_000,
    }),
    clusters: 16,
    iterations: Some(2),
    frames: 4,
    ..HAND
};

const CASES: [Case<'_>; 7] = [
    Case {
        name: "frame hand, 125 in contact, K=4 a module",
        presses: Some(Presses::EveryModule(125)),
        frames: ROUND,
        ..HAND
    },
    HAND,
    Case {
        name: "frame hand, idle, repeated",
        frames: 1,
        ..HAND
    },
    Case {
        name: "frame iCub, 200 of 2040 in contact, K=8",
        skin: "icub-body",
        presses: Some(Presses::Skin {
            presses: 8,
            taxels: 200,
        }),
        clusters: 8,
        scope: Scope::Skin,
        frames: ROUND,
        ..HAND
    },
    Case {
        name: "frame DIGIT, all in contact, K=16, two iterations",
        skin: "digit",
        presses: Some(Presses::Skin {
            presses: 16,
            taxels: 307_200,
        }),
        scope: Scope::Skin,
        ..MILLION
    },
    MILLION,
    Case {
        name: "frame million, a tenth in contact, K=16 a module, two iterations, all cores",
        parallel: true,
        ..MILLION
    },
];

/// Median time of a frame, microseconds.
fn time(case: &Case<'_>, layout: &Layout) -> Result<f64, Failure> {
    let (mut initialiser, scans) = scans(layout, case.presses, case.frames, None)?;
    let default = Settings::default();
    let settings = Settings {
        clusters: case.clusters,
        scope: case.scope,
        exponent: 2.0,
        max_iterations: case.iterations.unwrap_or(default.max_iterations),
        ..default
    };
    let failed = |e: &dyn std::fmt::Display| Failure::Input(format!("{}: {e}", case.name));
    let mut compressor = Compressor::new(layout, settings).map_err(|e| failed(&e))?;
    let mut frame = initialiser.frame(layout);
    let wanted = match case.presses {
        None => 0,
        Some(Presses::EveryModule(n) | Presses::Skin { taxels: n, .. }) => n,
    };
    let (mut at, mut failure) = (0, None);
    let mut race = Race::default();
    race.enter(|| {
        let scan = &scans[at % scans.len()];
        at += 1;
        let mut compress = || {
            if initialiser.advance(scan, &mut frame)? || !compressor.repeat() {
                if case.parallel {
                    compressor.compress_with(&frame, |scopes, locate| {
                        scopes.par_iter_mut().for_each(locate);
                    })?;
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
    for case in &CASES {
        let us = time(case, &skin(case.skin)?)?;
        findings.row(case.name, "default", NO_ERROR, us);
    }
    estimator("frame pad, 8 in contact", "uskin-4x4", 8, findings)?;
    estimator("frame hand, 125 in contact", "allegro", 125, findings)?;
    growth(findings)
}

/// Compares the time of a frame whose reference follows drift with that of one whose reference stays, in turn.
fn estimator(
    case: &str,
    name: &str,
    touched: usize,
    findings: &mut Findings,
) -> Result<(), Failure> {
    let layout = skin(name)?;
    let failed = |e: &dyn std::fmt::Display| Failure::Input(format!("{case}: {e}"));
    let is_wrong = Cell::new(false);
    let mut race = Race::default();
    for drift in [None, Some(Span::from_millis(5000))] {
        let presses = Some(Presses::EveryModule(touched));
        let (mut baseline, scans) = scans(&layout, presses, ROUND, drift)?;
        let mut compressor =
            Compressor::new(&layout, Settings::default()).map_err(|e| failed(&e))?;
        let (mut scan, mut frame) = (Scan::new(&layout), baseline.frame(&layout));
        let (mut number, is_wrong) = (0, &is_wrong);
        race.enter(move || {
            // Time goes on, as the estimator needs it to, while the scans repeat.
            let counts = scans[number % scans.len()].counts();
            number += 1;
            let at = Instant::from_micros(number as u64 * 10_000);
            let mut find = || {
                scan.load(at, counts).ok()?;
                baseline.advance(&scan, &mut frame).ok()?;
                compressor.compress(&frame).ok()?.first().copied()
            };
            is_wrong.set(find().is_none() || is_wrong.get());
        });
    }
    let samples = race.run(SAMPLES, BUDGET);
    if is_wrong.get() {
        return Err(failed(
            &"expected contacts in every frame, found none in some",
        ));
    }
    let [stays, follows] = [0, 1].map(|of| samples[of].median());
    findings.row(case, "reference stays", NO_ERROR, stays);
    findings.row(case, "reference follows drift", NO_ERROR, follows);
    let what = format!("{case}, reference follows drift (at most 1.3 times one that stays)");
    findings.target(&what, follows, 1.3 * stays);
    Ok(())
}

/// Time against the number of taxels, half of them in contact.
fn growth(findings: &mut Findings) -> Result<(), Failure> {
    let mut points = Vec::new();
    for side in [4, 8, 16, 32, 64, 128, 256, 512, 1000_u16] {
        let module = Module::grid("grid", side, side, 1.0);
        let layout = module.and_then(Layout::single);
        let layout = layout.map_err(|e| Failure::Input(format!("bench: {e}")))?;
        let taxels = usize::from(side) * usize::from(side);
        let name = format!("growth {taxels} taxels, K=8");
        let case = Case {
            name: &name,
            presses: Some(Presses::Skin {
                presses: 8,
                taxels: taxels / 2,
            }),
            clusters: 8,
            ..MILLION
        };
        let us = time(&case, &layout)?;
        findings.row(&name, "default", NO_ERROR, us);
        points.push((taxels as f64, us));
    }
    let series = vec![Series::new("K = 8", Mark::Ours, points)];
    let plot = Plot {
        x: Axis::decades("taxels"),
        y: Axis::decades("median run time [\u{b5}s]"),
        series,
    };
    findings.figures.push(plot.figure(
        "growth",
        "Time of a frame against the size of the skin",
        "Half of the taxels in contact under eight presses, warm, two iterations, one core: raw counts to contacts.",
    ));
    Ok(())
}
