//! Error against run time, tolerances swept, as work-precision diagrams show it.
//!
//! The reference is DOP853 at a relative tolerance of 1e-14: another method from another library. (In round-robin the
//! default and diffsol's best are all 1.8e-9 K from it, which is its own error.) Errors are over all seventeen nodes;
//! the largest over all edges and the one at the end are told apart.

use std::time::Duration;

use palpate_emulators::solver::stepped::Method as Stepping;
use palpate_emulators::time::Nanos;

use super::methods::{Method, Nodes};
use super::peers::Kind;
use super::train::{Case, pwm};
use crate::bench::plot::{Mark, Plot, Series};
use crate::bench::timing::Race;
use crate::bench::{Findings, Row};

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
    for us in [1000, 100, 10] {
        all.push(Method::Stepped(Stepping::Euler, Nanos::from_micros(us)));
    }
    for us in [1000, 200, 50, 10] {
        all.push(Method::Stepped(Stepping::Rk4, Nanos::from_micros(us)));
    }
    all.push(Method::Stepped(Stepping::CycleAveraged, pwm().0));
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

/// Largest distance of two courses over all edges and nodes, and the one at the end, K.
fn errors(a: &[Nodes], b: &[Nodes]) -> (f64, f64) {
    let apart = |(a, b): (&Nodes, &Nodes)| {
        let each = a.iter().zip(b).map(|(a, b)| (a - b).abs());
        // A NaN must not vanish in a maximum.
        each.fold(
            0.0,
            |worst: f64, d| if d.is_nan() { d } else { worst.max(d) },
        )
    };
    let mut worst = 0.0_f64;
    for pair in a.iter().zip(b) {
        let d = apart(pair);
        worst = if d.is_nan() || worst.is_nan() {
            f64::NAN
        } else {
            worst.max(d)
        };
    }
    let last = a.last().zip(b.last()).map_or(f64::NAN, apart);
    (worst, last)
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
                measured.push((method, errors(&seen, &reference)));
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
    let points: Vec<_> = measured
        .into_iter()
        .zip(samples.iter().map(|s| s.median()))
        .collect();
    findings.words.extend(compare(case.name, &points));
    for (suffix, pick) in [("", 0), (", at the end", 1)] {
        for &((method, errors), median_us) in &points {
            findings.rows.push(Row {
                family: "physics",
                case: format!("{}{suffix}", case.name),
                method: method.name(),
                error: if pick == 0 { errors.0 } else { errors.1 },
                error_unit: if pick == 0 { "K, largest" } else { "K" },
                median_us,
                peer: method.is_peer(),
            });
        }
        let mut series: Vec<Series> = Vec::new();
        for &((method, errors), median_us) in &points {
            let name = method.family();
            let point = (median_us, if pick == 0 { errors.0 } else { errors.1 });
            match series.iter_mut().find(|s| s.name == name) {
                Some(s) => s.points.push(point),
                None => series.push(Series {
                    name: name.into(),
                    points: vec![point],
                    mark: if method == Method::Default {
                        Mark::Ours
                    } else {
                        Mark::Swept
                    },
                }),
            }
        }
        findings.plots.push(Plot::work_precision(
            &format!("{}{}", case.name, if pick == 0 { "" } else { "-end" }),
            &format!(
                "{}, {}",
                case.name,
                if pick == 0 {
                    "largest error"
                } else {
                    "error at the end"
                }
            ),
            "error [K]",
            series,
        ));
    }
    Ok(())
}

/// A method with its largest and last error, K, and its median run time.
type Point = ((Method, (f64, f64)), f64);

/// How much faster the default is than each of diffsol's methods at equal error, or where that is most accurate.
fn compare(case: &str, points: &[Point]) -> Vec<String> {
    let Some(ours) = points.iter().find(|p| p.0.0 == Method::Default) else {
        return Vec::new();
    };
    let against = |kind| {
        let peers = points
            .iter()
            .filter(|p| matches!(p.0.0, Method::Diffsol(k, _) if k == kind && p.0.1.0.is_finite()));
        let equal = peers.clone().filter(|p| p.0.1.0 <= ours.0.1.0 * EQUAL);
        let words = |peer: &Point, verdict: &str| {
            format!(
                "{case}: default {:.1e} K; {} {:.1e} K in {:.0} times the run time ({verdict}).",
                ours.0.1.0,
                peer.0.0.name(),
                peer.0.1.0,
                peer.1 / ours.1
            )
        };
        match equal.min_by(|a, b| a.1.total_cmp(&b.1)) {
            Some(peer) if peer.1 >= AIM * ours.1 => Some(words(peer, "aim 100: met")),
            Some(peer) => Some(words(peer, "aim 100: missed")),
            None => peers
                .min_by(|a, b| a.0.1.0.total_cmp(&b.0.1.0))
                .map(|peer| words(peer, "its most accurate, never equal")),
        }
    };
    [Kind::Bdf, Kind::Tsit45]
        .into_iter()
        .filter_map(against)
        .collect()
}
