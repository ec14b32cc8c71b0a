//! Error against run time, tolerances swept, as work-precision diagrams show it.
//!
//! The reference is DOP853 at a relative tolerance of 1e-14: another method from another library. (In round-robin the
//! default and diffsol's best are all 1.8e-9 K from it, which is its own error.) Errors are over all seventeen nodes
//! and all edges, the largest of them.

use std::time::Duration;

use super::methods::Method;
use super::peers::Kind;
use super::train::{Case, Nodes};
use crate::findings::Findings;
use crate::plot::{Mark, Plot, Series};
use crate::timing::Race;

/// Tolerance of the reference.
const REFERENCE: f64 = 1e-14;
/// Samples of a method, and the time after which a slow one has enough of them.
const SAMPLES: usize = 31;
const BUDGET: Duration = Duration::from_millis(1500);
/// Shortest sample: as long as a call of the peers'.
const SAMPLE: Duration = Duration::from_millis(20);
/// Errors this many times the default's count as equal to it.
const EQUAL: f64 = 3.0;
/// Times faster at equal error that the default is to be.
const AIM: f64 = 100.0;

fn methods() -> Vec<Method> {
    let mut all = vec![Method::Default];
    for exponent in [3, 5, 7, 9, 11] {
        all.push(Method::Dop853(10_f64.powi(-exponent)));
    }
    for kind in [Kind::Bdf, Kind::Tsit45] {
        for exponent in [3, 5, 7, 9, 11, 12, 13, 14] {
            all.push(Method::Diffsol(kind, 10_f64.powi(-exponent)));
        }
    }
    all
}

/// Largest distance of two courses over all edges and nodes, K.
fn error(a: &[Nodes], b: &[Nodes]) -> f64 {
    let nodes = |(a, b): (&Nodes, &Nodes)| -> Nodes { std::array::from_fn(|i| a[i] - b[i]) };
    let apart = a.iter().zip(b).flat_map(nodes);
    // A NaN must not vanish in a maximum.
    apart.fold(0.0, |worst: f64, d| match d.is_nan() {
        true => d,
        false if worst.is_nan() => worst,
        false => worst.max(d.abs()),
    })
}

/// Both cases with all methods.
///
/// # Errors
/// A reference that cannot be computed.
pub fn measure(findings: &mut Findings) -> Result<(), String> {
    let cycling = Case::phase_cycling().map_err(|e| e.to_string())?;
    for case in [Case::round_robin(), cycling] {
        one(&case, findings)?;
    }
    Ok(())
}

fn one(case: &Case, findings: &mut Findings) -> Result<(), String> {
    let mut reference = Vec::new();
    Method::Dop853(REFERENCE).run(case, Some(&mut reference))?;
    let mut measured = Vec::new();
    let mut race = Race::of_samples(SAMPLE);
    for method in methods() {
        let mut seen = Vec::new();
        // What gives up before the end has no error and is not raced.
        match method.run(case, Some(&mut seen)) {
            Ok(()) => {
                measured.push((method, error(&seen, &reference)));
                race.enter(move || method.run(case, None));
            }
            Err(why) => {
                let (name, edge) = (method.name(), seen.len());
                let words = format!("{}: {name} gave up after edge {edge}: {why}.", case.name);
                findings.words.push(words);
            }
        }
    }
    let samples = race.run(SAMPLES, BUDGET);
    let timed = measured.into_iter().zip(&samples);
    let points: Vec<Point> = timed
        .map(|((method, error), samples)| Point {
            method,
            error,
            median_us: samples.median(),
        })
        .collect();
    findings.words.extend(compare(case.name, &points));
    let mut series: Vec<Series> = Vec::new();
    for point in &points {
        let (method, error) = (point.method, (point.error, "K, largest"));
        let (mark, add): (_, fn(&mut Findings, &str, &str, _, f64)) = match method {
            Method::Default => (Mark::Ours, Findings::row),
            _ => (Mark::Swept, Findings::peer),
        };
        add(findings, case.name, &method.name(), error, point.median_us);
        let at = (point.median_us, point.error);
        match series.iter_mut().find(|s| s.name == method.family()) {
            Some(s) => s.points.push(at),
            None => series.push(Series::new(method.family(), mark, vec![at])),
        }
    }
    let plot = Plot::work_precision("largest error [K]", series);
    let words = "Further left is faster, further down is more accurate.";
    let figure = plot.figure(case.name, case.name, words);
    findings.figures.push(figure);
    Ok(())
}

/// A method with its largest error, K, and its median run time.
struct Point {
    method: Method,
    error: f64,
    median_us: f64,
}

/// Speed of the default over each of diffsol's methods at equal error, or where that is most accurate.
fn compare(case: &str, points: &[Point]) -> Vec<String> {
    let Some(ours) = points.iter().find(|p| p.method == Method::Default) else {
        return Vec::new();
    };
    let against = |kind| {
        let peers = points.iter().filter(|p| {
            matches!(p.method, Method::Diffsol(k, _) if k == kind) && p.error.is_finite()
        });
        let equal = peers.clone().filter(|p| p.error <= ours.error * EQUAL);
        let words = |peer: &Point, verdict: &str| {
            format!(
                "{case}: default {:.1e} K; {} {:.1e} K in {:.0} times the run time ({verdict}).",
                ours.error,
                peer.method.name(),
                peer.error,
                peer.median_us / ours.median_us
            )
        };
        match equal.min_by(|a, b| a.median_us.total_cmp(&b.median_us)) {
            Some(peer) if peer.median_us >= AIM * ours.median_us => {
                Some(words(peer, "aim 100: met"))
            }
            Some(peer) => Some(words(peer, "aim 100: missed")),
            None => peers
                .min_by(|a, b| a.error.total_cmp(&b.error))
                .map(|peer| words(peer, "its most accurate, never equal")),
        }
    };
    [Kind::Bdf, Kind::Tsit45]
        .into_iter()
        .filter_map(against)
        .collect()
}
