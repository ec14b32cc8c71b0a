//! Frames to measure with: a press that wanders over every module, with an exact number of taxels in contact.

use std::error::Error;

use palpate_core::skin::{
    Initialiser, InitialiserSettings, Layout, Module, Phase, Scan, ThresholdRule,
};
use palpate_core::units::{Instant, Point};

/// Frames of one round of the path: 4 s at 100 Hz, as the shipped spheres roll.
pub const ROUND: usize = 400;
/// Frames of the reference.
pub const REFERENCE: usize = 10;

/// Raw counts of an untouched taxel.
const REST: [f32; 3] = [32_000.0, 31_000.0, 22_000.0];

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

/// Counts of one module with `touched` taxels in contact, those nearest to where the press is at `frame`.
fn module(module: &Module, frame: usize, phase: f64, touched: usize) -> Vec<[u16; 3]> {
    let turn = std::f64::consts::TAU * frame as f64 / ROUND as f64 + phase;
    let press = Point::new(
        5.0 * libm::sin(turn) as f32,
        5.0 * libm::sin(2.0 * turn) as f32,
    );
    let points = module.points();
    let mut order: Vec<usize> = (0..points.len()).filter(|&i| module.active()[i]).collect();
    order.sort_by(|&a, &b| {
        let (a, b) = (points[a].distance2(press), points[b].distance2(press));
        a.total_cmp(&b)
    });
    let mut counts: Vec<[u16; 3]> = (0..points.len())
        .map(|i| std::array::from_fn(|a| (REST[a] + noise(frame, i, a)) as u16))
        .collect();
    for &i in order.iter().take(touched) {
        let d2 = points[i].distance2(press);
        let strength = 150.0 + 2000.0 * libm::expf(-d2 / 40.0);
        counts[i][0] += (0.1 * strength) as u16;
        counts[i][2] += strength as u16;
    }
    counts
}

/// A whole skin at `frame`: `touched[m]` taxels of module m in contact.
pub fn counts(layout: &Layout, frame: usize, touched: &[usize]) -> Vec<[u16; 3]> {
    let modules = layout.modules().iter().zip(touched).enumerate();
    modules
        .flat_map(|(m, (shape, &n))| module(shape, frame, 0.4 * m as f64, n))
        .collect()
}

/// One round of scans and an initialiser that has seen the skin at rest.
///
/// # Errors
/// A layout that none of them fits.
pub fn scans(
    layout: &Layout,
    touched: &[usize],
) -> Result<(Initialiser, Vec<Scan>), Box<dyn Error>> {
    let settings = InitialiserSettings {
        reference_frames: REFERENCE as u32,
        threshold: ThresholdRule::Auto { margin: 10.0 },
        ..InitialiserSettings::default()
    };
    let mut initialiser = Initialiser::new(layout, settings)?;
    let untouched = vec![0; touched.len()];
    let mut scan = Scan::new(layout);
    for frame in 0..=REFERENCE {
        scan.load(Instant::ZERO, &counts(layout, frame, &untouched))?;
        initialiser.feed(&scan);
    }
    if initialiser.phase() != Phase::Ready {
        return Err("the initialiser is not ready after its reference".into());
    }
    let mut round = Vec::with_capacity(ROUND);
    for frame in 0..ROUND {
        scan.load(
            Instant::from_micros(frame as u64 * 10_000),
            &counts(layout, frame, touched),
        )?;
        round.push(scan.clone());
    }
    Ok((initialiser, round))
}
