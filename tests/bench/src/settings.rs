//! Gains and costs of settings: path and felt error of whole runs against the time of the loop.

use palpate_core::contact::Norm;
use palpate_files::Scene;
use palpate_hil::reproduce::setups::{changed, run};
use palpate_run::{Failure, Input};

use crate::findings::Findings;
use crate::plot::{Axis, Mark, Plot, Series};
use crate::scenes::frame_us;

/// The shipped paths of the sphere; settings are tried on the first.
pub const PATHS: [&str; 4] = [
    "sphere-circle",
    "sphere-across",
    "sphere-along",
    "sphere-diagonal",
];

/// A setting: its name, its values, a method's name for one of them, and what that changes.
pub struct Sweep {
    pub name: &'static str,
    pub values: &'static [f64],
    method: fn(f64) -> String,
    pub change: fn(&mut Scene, f64),
    /// True if its values trade time for error.
    drawn: bool,
}

/// Settings that are tried, one at a time.
pub const SWEEPS: [Sweep; 7] = [
    Sweep {
        name: "K_C",
        values: &[1.0, 2.0, 4.0, 8.0, 16.0],
        method: |kc| format!("K={kc}"),
        change: |s, kc| s.compression.kc = kc as u32,
        drawn: true,
    },
    Sweep {
        name: "K_C, one iteration",
        values: &[4.0, 16.0],
        method: |kc| format!("K={kc}, iterations 1"),
        change: |s, kc| {
            s.compression.kc = kc as u32;
            s.compression.iterations = 1;
        },
        drawn: true,
    },
    Sweep {
        name: "cadence",
        values: &[60.0, 80.0, 105.0, 125.0],
        method: |ms| format!("SOA {ms} ms"),
        change: |s, ms| {
            s.illusion.soa_ms = Some(ms);
        },
        drawn: true,
    },
    Sweep {
        name: "weights",
        values: &[0.0, 1.0, 2.0, 3.0, 4.0],
        method: |p| format!("p={p}"),
        change: |s, p| s.compression.weight_exponent = p,
        drawn: true,
    },
    Sweep {
        name: "frames left out",
        values: &[25.0, 50.0],
        method: |hz| format!("{hz} Hz"),
        change: |s, hz| {
            s.rate_hz = hz;
            s.reference_frames = 10;
        },
        drawn: true,
    },
    Sweep {
        name: "norm",
        values: &[1.0, 2.0, f64::INFINITY],
        method: |l| format!("l{l}"),
        change: |s, l| {
            s.compression.norm = match l {
                1.0 => Norm::L1,
                2.0 => Norm::L2,
                _ => Norm::LInf,
            };
        },
        drawn: false,
    },
    Sweep {
        name: "noise",
        values: &[0.25, 0.5, 1.0, 2.0, 4.0, 8.0],
        method: |factor| format!("x {factor}"),
        change: |s, factor| s.noise_lsb = s.noise_lsb.map(|lsb| lsb * factor),
        drawn: false,
    },
];

/// Rows of a changed scene; its felt error, mm, behind the time of the loop per second of touch, microseconds.
fn point(
    findings: &mut Findings,
    name: &str,
    method: &str,
    change: impl FnOnce(&mut Scene),
) -> Result<(f64, f64), Failure> {
    let setup = changed(name, change)?;
    let outcome = run(&setup, &Input::Scene)?;
    // The loop's whole time per second of the scene: frames left out cost nothing.
    // The median stands for every frame, so that a machine with other work to do does not count.
    let frame = frame_us(&outcome);
    let spent = frame * f64::from(outcome.summary.frames) / setup.scene.value.length_s;
    let path = outcome.summary.path_error_mm.map_or(f64::NAN, |e| e.rmse);
    let felt = outcome.summary.felt_error_mm.rmse.unwrap_or(f64::NAN);
    let case = format!("path {name}, per frame");
    findings.row(&case, method, (path, "mm path RMSE"), frame);
    let case = format!("felt {name}, per second");
    findings.row(&case, method, (felt, "mm felt RMSE"), spent);
    Ok((spent, felt))
}

/// Measures every path at its defaults, and every setting for itself.
///
/// # Errors
/// A scene that does not run.
pub fn measure(findings: &mut Findings) -> Result<(), Failure> {
    let mut series = Vec::new();
    for name in PATHS {
        let at = point(findings, name, "default", |_| ())?;
        if name == PATHS[0] {
            series.push(Series::new("default", Mark::Ours, vec![at]));
        }
    }
    for sweep in SWEEPS {
        let mut points = Vec::new();
        for &value in sweep.values {
            let method = (sweep.method)(value);
            let change = |scene: &mut Scene| (sweep.change)(scene, value);
            points.push(point(findings, PATHS[0], &method, change)?);
        }
        if sweep.drawn {
            series.push(Series::new(sweep.name, Mark::Swept, points));
        }
    }
    let plot = Plot {
        x: Axis::decades("time of the loop per second of touch [\u{b5}s]"),
        ..Plot::work_precision("felt RMSE [mm]", series)
    };
    findings.figures.push(plot.figure(
        "felt",
        "Felt error against the time of the whole loop",
        "Further left is faster, further down is more accurate.",
    ));
    Ok(())
}
