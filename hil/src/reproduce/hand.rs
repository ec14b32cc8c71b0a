//! Rows of figure 4.7: the hand of 15 modules at about 30 Hz, which holds twenty things of the YCB set.

use std::collections::BTreeMap;

use palpate_files::{Force, Path, PathKind, Scene, Setup, ThresholdFrom, Touch};
use palpate_records::trace::{Event, event};
use palpate_run::{Failure, Outcome};
use serde_json::json;

use super::row::{Answer, Mark, Row};
use super::sphere::{CLUSTERS, changed, hertz, run};

pub(super) const ROWS: &[Row] = &[
    Row {
        id: "claim-4.4.2-rate",
        says: "The hand is read at about 30 Hz.",
        assumed: "All 15 boards wait for one another on one CAN bus of 1 Mbit/s.",
        compute: rate,
    },
    Row {
        id: "fig-4.7-contacts",
        says: "While the hand moves a thing, 75 to 125 taxels are in contact.",
        assumed: "Twenty things of the YCB set by size and weight (recalled), held twice as hard as their weight asks at a friction of 0.5; a flat or soft thing is a very wide sphere. Threshold of (4.3), no margin.",
        compute: contacts,
    },
    Row {
        id: "fig-4.7-speed",
        says: "Compression rarely falls below the hand's 30 Hz, except for K_C = 16.",
        assumed: "This machine, one core: the whole loop. The football of fig-4.7-contacts.",
        compute: speed,
    },
];

/// A thing in the hand: name, diameter where a finger meets it in mm, weight in kg.
type Thing = (&'static str, f64, f64);

/// Diameter that stands for a face without curvature, mm.
const FLAT: f64 = 1000.0;

/// The things that figure 4.7 shows, then others of the set. Flat and soft ones are [`FLAT`].
const THINGS: [Thing; 20] = [
    ("football", 140.0, 0.123),
    ("baseball", 75.0, 0.148),
    ("pack of foam", FLAT, 0.056),
    ("foam block", FLAT, 0.028),
    ("softball", 96.0, 0.191),
    ("tennis ball", 64.7, 0.058),
    ("racquetball", 55.3, 0.041),
    ("golf ball", 42.7, 0.046),
    ("apple", 75.0, 0.068),
    ("orange", 73.0, 0.047),
    ("lemon", 54.0, 0.029),
    ("peach", 59.0, 0.033),
    ("plum", 52.0, 0.025),
    ("soup can", 66.0, 0.349),
    ("chips can", 75.0, 0.205),
    ("tuna can", 85.0, 0.171),
    ("sugar box", FLAT, 0.514),
    ("cracker box", FLAT, 0.411),
    ("pudding box", FLAT, 0.187),
    ("gelatin box", FLAT, 0.097),
];

/// Friction of a thing in the hand, assumed.
const FRICTION: f64 = 0.5;
/// The hand holds a thing this many times as hard as its weight asks, assumed.
const RESERVE: f64 = 2.0;
/// Modules of the hand.
const MODULES: usize = 15;

/// Force of each module on a thing of so many kg that all of them hold, N.
fn grip(weight_kg: f64) -> f64 {
    RESERVE * weight_kg * 9.81 / (FRICTION * MODULES as f64)
}

/// A grasp: every module is pressed by the same thing, each a little elsewhere.
fn grasp(scene: &mut Scene, diameter_mm: f64, force: f64) {
    scene.length_s = 4.5;
    scene.threshold = ThresholdFrom::Maximum;
    scene.threshold_margin = 0.0;
    let touch = |module: usize| {
        let turn = 2.4 * module as f64;
        Touch {
            module,
            diameter_mm,
            start_s: 2.0,
            end_s: 4.4,
            ramp_s: 0.2,
            path: Path {
                kind: PathKind::Circle,
                points_mm: Vec::new(),
                centre_mm: Some([2.0 * turn.cos(), 2.0 * turn.sin()]),
                radius_mm: Some(1.5),
                period_s: Some(2.0),
                samples: Vec::new(),
            },
            force_n: Force {
                mean: force * (0.8 + 0.4 * (module % 4) as f64 / 3.0),
                amplitude: 0.1 * force,
                period_s: 1.1,
            },
        }
    };
    scene.touches = (0..MODULES).map(touch).collect();
}

fn held(kc: u32, diameter_mm: f64, force: f64) -> Result<Setup, Failure> {
    changed("allegro-one-bus", |scene| {
        scene.compression.kc = kc;
        grasp(scene, diameter_mm, force);
    })
}

/// Fewest and most taxels in contact in a frame while a thing is held.
fn span(outcome: &Outcome) -> (u32, u32) {
    let mut frames = BTreeMap::new();
    for event in &outcome.trace.events {
        if let Event::Contact(event::Contact { t_us, members, .. }) = event
            && (2_400_000..4_000_000).contains(t_us)
        {
            *frames.entry(*t_us).or_insert(0) += *members;
        }
    }
    let least = frames.values().copied().min().unwrap_or(0);
    (least, frames.values().copied().max().unwrap_or(0))
}

fn rate() -> Result<Answer, Failure> {
    let outcome = run(&changed("allegro-one-bus", |_| {})?)?;
    let hz = f64::from(outcome.summary.frames) / 6.0;
    let taxels = outcome.summary.taxels.refresh_hz.map_or(0.0, |r| r.median);
    Ok(Answer::new(
        Mark::of((25.0..=36.0).contains(&hz), || {
            "the bus has room for more".into()
        }),
        format!(
            "{hz:.1} frames per second; the median taxel changes {taxels:.1} times per second."
        ),
        json!({ "frames_hz": hz }),
    ))
}

fn contacts() -> Result<Answer, Failure> {
    let mut each = Vec::new();
    for (name, diameter_mm, weight_kg) in THINGS {
        let outcome = run(&held(1, diameter_mm, grip(weight_kg))?)?;
        each.push((name, span(&outcome)));
    }
    let fits = |span: &(u32, u32)| span.0 >= 75 && span.1 <= 125;
    let within = each.iter().filter(|(_, span)| fits(span)).count();
    let mut sweep = Vec::new();
    for newtons in [0.03, 0.05, 0.1, 0.15, 0.2, 0.3, 0.5] {
        let outcome = run(&held(1, 140.0, newtons)?)?;
        sweep.push((newtons, span(&outcome)));
    }
    let told = |all: &mut dyn Iterator<Item = (String, (u32, u32))>| {
        let each = all.map(|(name, (least, most))| format!("{name} {least} to {most}"));
        each.collect::<Vec<_>>().join(", ")
    };
    let cause = told(&mut sweep.iter().map(|(n, span)| (format!("{n} N"), *span)));
    let shown = told(
        &mut each
            .iter()
            .take(4)
            .map(|(n, span)| ((*n).to_owned(), *span)),
    );
    let least = each.iter().map(|(_, span)| span.0).min().unwrap_or(0);
    let most = each.iter().map(|(_, span)| span.1).max().unwrap_or(0);
    Ok(Answer::new(
        Mark::of(within == each.len(), || {
            format!(
                "the grip, which the thesis does not print. The football by force of a module: {cause}"
            )
        }),
        format!(
            "{shown}; {least} to {most} over all twenty, of which {within} stay within 75 to 125."
        ),
        json!({
            "things": each.iter().map(|e| e.0).collect::<Vec<_>>(),
            "spans": each.iter().map(|e| e.1).collect::<Vec<_>>(),
            "sweep_n": sweep.iter().map(|s| s.0).collect::<Vec<_>>(),
            "sweep_spans": sweep.iter().map(|s| s.1).collect::<Vec<_>>(),
        }),
    ))
}

fn speed() -> Result<Answer, Failure> {
    let (_, diameter_mm, weight_kg) = THINGS[0];
    let mut slower = Vec::new();
    for kc in CLUSTERS {
        if hertz(&run(&held(kc, diameter_mm, grip(weight_kg))?)?) < 30.0 {
            slower.push(kc);
        }
    }
    let (mark, found) = match slower.as_slice() {
        [16] => (
            Mark::Agrees,
            "Slower than 30 Hz for K_C = 16 alone.".to_owned(),
        ),
        [] => (
            Mark::Unexplained,
            "Faster than 30 Hz for every K_C, 16 too.".to_owned(),
        ),
        other => (
            Mark::Unexplained,
            format!("Slower than 30 Hz for K_C of {other:?}."),
        ),
    };
    Ok(Answer::new(mark, found, json!({ "slower_at": slower })))
}
