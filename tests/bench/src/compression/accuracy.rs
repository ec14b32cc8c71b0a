//! How far contacts are from where the sphere truly is: over noise, K_C, the weights' exponent p and norm l.

use palpate_core::contact::Norm;
use palpate_files::Scene;
use palpate_run::{Failure, Input};

use crate::findings::Findings;
use crate::scenes::{changed, frame_us, run};

/// The shipped paths of the sphere.
const PATHS: [&str; 4] = [
    "sphere-across",
    "sphere-along",
    "sphere-circle",
    "sphere-diagonal",
];
/// The path on which settings are tried.
const CIRCLE: &str = "sphere-circle";

/// A row with the path error of a changed scene.
fn path(
    findings: &mut Findings,
    (case, method): (&str, &str),
    name: &str,
    change: impl FnOnce(&mut Scene),
) -> Result<(), Failure> {
    let outcome = run(&changed(name, change)?, &Input::Scene)?;
    let rmse = outcome.summary.path_error_mm.map_or(f64::NAN, |e| e.rmse);
    let case = format!("{case} {name}");
    findings.row(&case, method, (rmse, "mm path RMSE"), frame_us(&outcome));
    Ok(())
}

/// Measures the paths at their defaults, and each setting for itself.
///
/// # Errors
/// A scene that does not run.
pub(super) fn measure(findings: &mut Findings) -> Result<(), Failure> {
    for name in PATHS {
        path(findings, ("path", "default"), name, |_| {})?;
    }
    for factor in [0.25, 0.5, 1.0, 2.0, 4.0, 8.0] {
        let method = format!("x {factor}");
        path(findings, ("noise", &method), CIRCLE, |scene| {
            scene.noise_lsb = scene.noise_lsb.map(|lsb| lsb * factor);
        })?;
    }
    for kc in [1, 2, 4, 8, 16] {
        path(findings, ("K_C", &format!("K={kc}")), CIRCLE, |scene| {
            scene.compression.kc = kc;
        })?;
    }
    for p in [0.0, 1.0, 2.0, 3.0, 4.0] {
        path(findings, ("p", &format!("p={p}")), CIRCLE, |scene| {
            scene.compression.weight_exponent = p;
        })?;
    }
    for (name, norm) in [("l1", Norm::L1), ("l2", Norm::L2), ("linf", Norm::LInf)] {
        path(findings, ("l", name), CIRCLE, |scene| {
            scene.compression.norm = norm;
        })?;
    }
    Ok(())
}
