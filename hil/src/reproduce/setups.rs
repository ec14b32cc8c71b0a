//! Set-ups of the thesis's figures, as scenes: for rows here, and for programs that draw the figures.

use std::collections::BTreeMap;

use palpate_files::{
    Force, Path, PathKind, Scene, Setup, ThresholdFrom, Touch, load_bench, load_scene,
};
use palpate_live::host;
use palpate_live::views::Wanted;
use palpate_records::trace::event;
use palpate_run::{Failure, Input, Keep, Outcome};

/// Most contacts that figures 4.6 and 4.7 ask for.
pub const CLUSTERS: [u32; 5] = [1, 2, 4, 8, 16];

/// Changes a shipped scene and joins it with the default bench.
///
/// # Errors
/// A scene that does not fit the bench.
pub fn changed(name: &str, change: impl FnOnce(&mut Scene)) -> Result<Setup, Failure> {
    let mut scene = load_scene(name)?;
    change(&mut scene.value);
    Ok(Setup::join(scene, load_bench("emulated")?)?)
}

/// Runs a scene with every frame timed.
///
/// # Errors
/// The errors of [`host::run`].
pub fn run(setup: &Setup, input: &Input) -> Result<Outcome, Failure> {
    host::run(setup, input, 1, Keep::default(), Wanted::default())
}

/// Runs the touches of a scene with every frame timed.
pub(super) fn played(setup: &Setup) -> Result<Outcome, Failure> {
    run(setup, &Input::Scene)
}

/// Frames of a run per second, from the first to the last.
pub(super) fn rate_hz(outcome: &Outcome) -> f64 {
    let times: Vec<u64> = outcome
        .trace
        .each()
        .map(|f: &event::Frame| f.t_us)
        .collect();
    match times.as_slice() {
        [first, .., last] if last > first => (times.len() - 1) as f64 * 1e6 / (last - first) as f64,
        _ => 0.0,
    }
}

/// Median speed of a run, frames per second.
pub fn hertz(outcome: &Outcome) -> f64 {
    outcome
        .summary
        .frame_us
        .map_or(0.0, |time| 1e6 / time.median)
}

/// Roll of a sphere over one module from bottom to top, frames 102 to 210 as in figure 4.5, with the threshold of (4.3).
/// The force is `mean` newtons at the bottom and `rise` more at the top.
///
/// # Errors
/// A scene that does not fit the bench.
pub fn roll(kc: u32, mean: f64, rise: f64) -> Result<Setup, Failure> {
    changed("sphere-along", |scene| {
        scene.length_s = 2.4;
        scene.compression.kc = kc;
        scene.threshold = ThresholdFrom::Maximum;
        scene.threshold_margin = 0.0;
        for touch in &mut scene.touches {
            touch.start_s = 1.02;
            touch.end_s = 2.1;
            touch.ramp_s = 0.01;
            touch.path.period_s = None;
            // A quarter of a wave: its most is at the top.
            touch.force_n = Force {
                mean,
                amplitude: rise,
                period_s: 4.32,
            };
        }
    })
}

/// Thing in the hand: name, diameter where a finger meets it in mm, weight in kg.
pub type Thing = (&'static str, f64, f64);

/// Diameter that stands for a face without curvature, mm.
const FLAT: f64 = 1000.0;

/// Things that figure 4.7 shows, then others of the YCB set. Flat and soft ones have a face without curvature.
pub const THINGS: [Thing; 20] = [
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
pub fn grip(weight_kg: f64) -> f64 {
    RESERVE * weight_kg * 9.81 / (FRICTION * MODULES as f64)
}

/// A grasp: every module is pressed by the same thing, each a little elsewhere.
pub fn grasp(scene: &mut Scene, diameter_mm: f64, force: f64) {
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

/// Fewest and most taxels in contact in a frame while a thing is held.
pub fn span(outcome: &Outcome) -> (u32, u32) {
    let mut frames = BTreeMap::new();
    let contacts = outcome.trace.each::<event::Contact>();
    for contact in contacts.filter(|c| (2_400_000..4_000_000).contains(&c.t_us)) {
        *frames.entry(contact.t_us).or_insert(0) += contact.members;
    }
    let least = frames.values().copied().min().unwrap_or(0);
    (least, frames.values().copied().max().unwrap_or(0))
}
