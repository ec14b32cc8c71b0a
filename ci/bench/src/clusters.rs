//! Our warm K-means beside the textbook's, on the same points in the same run, call by call in turn.

use std::error::Error;
use std::io::{self, Write};

use palpate_core::contact::kmeans::{KMeans, Points, Stop};
use palpate_core::random::Stream;

use crate::frames::ROUND;
use crate::textbook::{self, Draw};
use crate::timing::{Samples, time};

/// The stop rule of the shipped settings.
const STOP: Stop = Stop {
    tolerance: 1e-3,
    max_iterations: 32,
};

/// Points of one frame, in both forms.
struct Cloud {
    x: Vec<f32>,
    y: Vec<f32>,
    w: Vec<f32>,
    rows: Vec<(f32, f32, f32)>,
}

/// `n` taxels of a grid under `k` presses that wander, at `frame`.
fn cloud(n: usize, k: usize, frame: usize) -> Cloud {
    let columns = (1..).find(|c| c * c >= n).unwrap_or(1);
    let half = 0.5 * 4.7 * (columns as f64 - 1.0);
    let turn = std::f64::consts::TAU * frame as f64 / ROUND as f64;
    let presses: Vec<(f64, f64)> = (0..k)
        .map(|p| {
            let home = std::f64::consts::TAU * p as f64 / k as f64;
            let reach = 0.7 * half * (0.8 + 0.2 * libm::sin(turn + p as f64));
            let at = home + 0.3 * libm::sin(turn);
            (reach * libm::cos(at), reach * libm::sin(at))
        })
        .collect();
    let rows: Vec<(f32, f32, f32)> = (0..n)
        .map(|i| {
            let x = 4.7 * (i % columns) as f64 - half;
            let y = half - 4.7 * (i / columns) as f64;
            let w = presses.iter().map(|(px, py)| {
                let d2 = (x - px) * (x - px) + (y - py) * (y - py);
                libm::exp(-d2 / 40.0)
            });
            (x as f32, y as f32, (0.05 + w.sum::<f64>()) as f32)
        })
        .collect();
    Cloud {
        x: rows.iter().map(|r| r.0).collect(),
        y: rows.iter().map(|r| r.1).collect(),
        w: rows.iter().map(|r| r.2).collect(),
        rows,
    }
}

/// The weighted squared distance of all points to their nearest centroid: what K-means makes small.
fn inertia(rows: &[(f32, f32, f32)], centroids: &[(f64, f64)]) -> f64 {
    let cost = |&(x, y, w): &(f32, f32, f32)| {
        let (x, y) = (f64::from(x), f64::from(y));
        let d2 = centroids
            .iter()
            .map(|c| (c.0 - x) * (c.0 - x) + (c.1 - y) * (c.1 - y));
        f64::from(w) * d2.fold(f64::INFINITY, f64::min)
    };
    rows.iter().map(cost).sum()
}

/// Prints medians of ours and of the textbook, and how much longer the textbook takes.
///
/// # Errors
/// A closed standard output.
pub fn bench() -> Result<(), Box<dyn Error>> {
    let mut out = io::stdout().lock();
    writeln!(
        out,
        "\n| K-means alone | ours warm, us | passes | textbook warm, us | ratio | textbook cold, us | ratio | cost to cold |\n\
         |---|---:|---:|---:|---:|---:|---:|---:|"
    )?;
    for (n, k) in [(12, 4), (16, 8), (125, 4), (240, 8), (2000, 16)] {
        let round: Vec<Cloud> = (0..ROUND).map(|f| cloud(n, k, f)).collect();
        let mut ours = KMeans::new(n, k);
        let (mut stream, mut draw) = (Stream::new(1, "bench"), Draw(1));
        let mut warm = Vec::new();
        let (mut a, mut b, mut c) = (Samples::default(), Samples::default(), Samples::default());
        let (mut passes, mut cost) = (0, (0.0, 0.0));
        for step in 0..10 * ROUND {
            let cloud = &round[step % ROUND];
            let points = Points {
                x: &cloud.x,
                y: &cloud.y,
                w: &cloud.w,
            };
            if step == 0 {
                ours.seed(points, k, &mut stream);
                warm = textbook::kmeans(&cloud.rows, k, None, &mut draw);
            }
            let (ours_us, outcome) = time(|| ours.solve(points, STOP));
            let (warm_us, next) = time(|| textbook::kmeans(&cloud.rows, k, Some(&warm), &mut draw));
            let (cold_us, fresh) = time(|| textbook::kmeans(&cloud.rows, k, None, &mut draw));
            warm = next;
            if step >= ROUND {
                passes += outcome.iterations;
                a.push(ours_us);
                b.push(warm_us);
                c.push(cold_us);
                cost.0 += ours.inertia(points);
                cost.1 += inertia(&cloud.rows, &fresh);
            }
        }
        let (ours, warm, cold) = (a.median(), b.median(), c.median());
        let passes = f64::from(passes) / a.len() as f64;
        writeln!(
            out,
            "| {n} points, K = {k} | {ours:.2} | {passes:.2} | {warm:.2} | {:.1} | {cold:.2} | {:.1} | {:.3} |",
            warm / ours,
            cold / ours,
            cost.0 / cost.1
        )?;
    }
    Ok(())
}
