//! How far contacts are from where the sphere truly is: over noise, K_C, the weights' exponent p and norm l.

use crate::bench::plot::{Axis, Mark, Plot, Series};
use crate::bench::{Findings, Row};
use crate::failure::Failure;
use crate::run::{Input, run};
use palpate_files::{Norm, Scene, Setup, load_bench, load_scene};

/// The shipped paths of the sphere.
const PATHS: [&str; 4] = [
    "sphere-across",
    "sphere-along",
    "sphere-circle",
    "sphere-diagonal",
];

/// Path error of a changed scene, RMSE in sensor mm, and median time of a frame, microseconds.
fn path(name: &str, change: &dyn Fn(&mut Scene)) -> Result<(f64, f64), Failure> {
    let mut scene = load_scene(name)?;
    change(&mut scene.value);
    let setup = Setup::join(scene, load_bench("emulated")?)?;
    let summary = run(&setup, &Input::Scene, 1)?.summary;
    let rmse = summary.path_error_mm.map_or(f64::NAN, |e| e.rmse);
    Ok((rmse, summary.frame_us.map_or(f64::NAN, |t| t.median)))
}

fn row(findings: &mut Findings, case: &str, method: &str, (error, median_us): (f64, f64)) {
    findings.rows.push(Row {
        family: "compression",
        case: case.into(),
        method: method.into(),
        error,
        error_unit: "mm path RMSE",
        median_us,
        peer: false,
    });
}

/// Measures the paths at their defaults, and each setting for itself.
///
/// # Errors
/// A scene that does not run.
pub(super) fn measure(findings: &mut Findings) -> Result<(), Failure> {
    for name in PATHS {
        row(
            findings,
            &format!("path {name}"),
            "default",
            path(name, &|_| {})?,
        );
    }
    let mut series = Vec::new();
    for name in PATHS {
        let mut points = Vec::new();
        for factor in [0.25, 0.5, 1.0, 2.0, 4.0, 8.0] {
            let got = path(name, &|scene| {
                scene.noise_lsb = scene.noise_lsb.map(|lsb| lsb * factor);
            })?;
            row(
                findings,
                &format!("noise {name}"),
                &format!("x {factor}"),
                got,
            );
            points.push((factor, got.0));
        }
        series.push(Series {
            name: name.into(),
            points,
            mark: Mark::Swept,
        });
    }
    findings.plots.push(Plot {
        name: "noise".into(),
        title: "Path error against noise".into(),
        words: "Noise of every taxel as a multiple of the shipped scenes'.".into(),
        x: Axis {
            label: "noise".into(),
            log: true,
        },
        y: Axis {
            label: "path RMSE [mm]".into(),
            log: false,
        },
        series,
    });
    let circle = "sphere-circle";
    for kc in [1, 2, 4, 8, 16] {
        let got = path(circle, &|scene| scene.compression.kc = kc)?;
        row(findings, "K_C sphere-circle", &format!("K={kc}"), got);
    }
    let mut points = Vec::new();
    for p in [0.0, 0.5, 1.0, 1.5, 2.0, 3.0, 4.0, 8.0] {
        let got = path(circle, &|scene| scene.compression.weight_exponent = p)?;
        row(findings, "p sphere-circle", &format!("p={p}"), got);
        points.push((p, got.0));
    }
    findings.plots.push(Plot {
        name: "exponent".into(),
        title: "Path error against the weights' exponent".into(),
        words: "The circle, weights ||s||^p.".into(),
        x: Axis {
            label: "p".into(),
            log: false,
        },
        y: Axis {
            label: "path RMSE [mm]".into(),
            log: false,
        },
        series: vec![Series {
            name: circle.into(),
            points,
            mark: Mark::Ours,
        }],
    });
    for (name, norm) in [("l1", Norm::L1), ("l2", Norm::L2), ("linf", Norm::Linf)] {
        let got = path(circle, &|scene| scene.compression.norm = norm)?;
        row(findings, "l sphere-circle", name, got);
    }
    Ok(())
}
