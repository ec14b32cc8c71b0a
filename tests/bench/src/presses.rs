//! Frames of any skin: presses that wander over it, with an exact number of taxels in contact.

use palpate_core::skin::{Baseline, BaselinePhase, BaselineSettings, Layout, Scan, ThresholdRule};
use palpate_core::units::{Duration, Instant, Point};

use palpate_run::Failure;

/// Frames of one round of the path.
pub const ROUND: usize = 400;
/// Frames of the reference.
const REFERENCE: usize = 10;
/// Raw counts of an untouched taxel.
const REST: [f32; 3] = [32_000.0, 31_000.0, 22_000.0];

/// Presses that touch a skin.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Presses {
    /// One press on every module, so many taxels of each (module m of n: [`Presses::on_module`]).
    EveryModule(usize),
    /// A number of presses on the skin's plane, and a number of taxels altogether.
    Skin {
        /// Presses.
        presses: usize,
        /// Taxels in contact.
        taxels: usize,
    },
}

impl Presses {
    /// Taxels in contact on module `m` where `total` are spread over `modules` evenly.
    fn on_module(total: usize, modules: usize, m: usize) -> usize {
        (m + 1) * total / modules - m * total / modules
    }
}

/// A repeatable wiggle of a few counts, as sensor noise is.
fn noise(frame: usize, taxel: usize, axis: usize) -> f32 {
    let mut bits = (frame * 7919 + taxel * 104_729 + axis * 1_299_709 + 1) as u32;
    for _ in 0..3 {
        bits ^= bits << 13;
        bits ^= bits >> 17;
        bits ^= bits << 5;
    }
    (bits % 5) as f32 - 2.0
}

/// The nearest `touched` of some taxels, given squared distances, get counts.
fn press(distances: &mut [(f32, usize)], touched: usize, scale: f32, counts: &mut [[u16; 3]]) {
    if touched == 0 {
        return;
    }
    if touched < distances.len() {
        distances
            .select_nth_unstable_by(touched - 1, |a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    }
    for &(d2, i) in distances.iter().take(touched) {
        let strength = 150.0 + 2000.0 * libm::expf(-d2 / scale);
        counts[i][0] += (0.1 * strength) as u16;
        counts[i][2] += strength as u16;
    }
}

/// A whole skin at `frame`.
pub fn counts(layout: &Layout, frame: usize, presses: Option<Presses>) -> Vec<[u16; 3]> {
    let mut counts: Vec<[u16; 3]> = (0..layout.taxels())
        .map(|i| std::array::from_fn(|a| (REST[a] + noise(frame, i, a)) as u16))
        .collect();
    let turn = std::f64::consts::TAU * frame as f64 / ROUND as f64;
    let places = |m: usize| {
        let (module, range) = (&layout.modules()[m], layout.range(m));
        let taxels = module.points().iter().zip(module.active()).zip(range);
        taxels
            .filter(|((_, active), _)| **active)
            .map(|((p, _), i)| (*p, i))
    };
    match presses {
        None => {}
        Some(Presses::EveryModule(total)) => {
            let modules = layout.modules().len();
            for m in 0..modules {
                let turn = turn + 0.4 * m as f64;
                let at = Point::new(
                    5.0 * libm::sin(turn) as f32,
                    5.0 * libm::sin(2.0 * turn) as f32,
                );
                let mut near: Vec<_> = places(m).map(|(p, i)| (p.distance2(at), i)).collect();
                press(
                    &mut near,
                    Presses::on_module(total, modules, m),
                    40.0,
                    &mut counts,
                );
            }
        }
        Some(Presses::Skin { presses, taxels }) => {
            let all: Vec<(Point, usize)> = (0..layout.modules().len())
                .flat_map(|m| {
                    let o = layout.modules()[m].origin();
                    places(m).map(move |(p, i)| (Point::new(p.x + o.x, p.y + o.y), i))
                })
                .collect();
            let far = all.iter().fold((1e-3f32, 1e-3f32), |b, (p, _)| {
                (b.0.max(p.x.abs()), b.1.max(p.y.abs()))
            });
            let at = |p: usize| {
                let home =
                    std::f64::consts::TAU * p as f64 / presses as f64 + 0.3 * libm::sin(turn);
                Point::new(
                    0.6 * far.0 * libm::cos(home) as f32,
                    0.6 * far.1 * libm::sin(home) as f32,
                )
            };
            let at: Vec<Point> = (0..presses).map(at).collect();
            let near = |p: &Point| {
                at.iter()
                    .map(|a| a.distance2(*p))
                    .fold(f32::INFINITY, f32::min)
            };
            let mut near: Vec<_> = all.iter().map(|(p, i)| (near(p), *i)).collect();
            press(&mut near, taxels, far.0 * far.1 * 0.05, &mut counts);
        }
    }
    counts
}

/// A baseline that has seen the skin at rest, and follows its drift with a time constant where one is given; and `frames` scans.
///
/// # Errors
/// A layout that none of them fits.
pub fn scans(
    layout: &Layout,
    presses: Option<Presses>,
    frames: usize,
    drift: Option<Duration>,
) -> Result<(Baseline, Vec<Scan>), Failure> {
    let failed = |e: &dyn std::fmt::Display| Failure::Input(format!("bench: {e}"));
    let settings = BaselineSettings {
        reference_frames: REFERENCE as u32,
        threshold: ThresholdRule::Auto { margin: 10.0 },
        drift,
        ..BaselineSettings::default()
    };
    let mut baseline = Baseline::new(layout, settings).map_err(|e| failed(&e))?;
    let mut scan = Scan::new(layout);
    for frame in 0..=REFERENCE {
        scan.load(Instant::ZERO, &counts(layout, frame, None))
            .map_err(|e| failed(&e))?;
        baseline.feed(&scan);
    }
    if baseline.phase() != BaselinePhase::Ready {
        return Err(failed(&"the baseline is not ready after its reference"));
    }
    let mut round = Vec::with_capacity(frames);
    for frame in 0..frames {
        let at = Instant::from_micros(frame as u64 * 10_000);
        scan.load(at, &counts(layout, frame, presses))
            .map_err(|e| failed(&e))?;
        round.push(scan.clone());
    }
    Ok((baseline, round))
}
