//! The trap that this solver was built around: a general solver called once over a train of short pulses steps
//! across them, whatever its tolerance.

use ode_solvers::dop853::Dop853;
use ode_solvers::dopri5::Dopri5;
use ode_solvers::{OutputType, SVector, System};
use palpate_core::physics::WireParameters;
use palpate_emulators::finger::{NODES, Network};
use palpate_emulators::wire::Wire;

use super::train::{Bursts, Case, START_C, ms};
use crate::bench::plot::{Axis, Mark, Plot, Series};
use crate::bench::{Findings, Row};

/// One burst of the round-robin and the pause behind it, s.
const LENGTH_MS: u64 = 200;
const TOLERANCES: [f64; 3] = [1e-3, 1e-5, 1e-7];

/// The whole train as one right-hand side: the power is looked up by time.
struct Train<'a> {
    network: &'a Network,
    wire: &'a WireParameters,
    case: &'a Case,
}

impl System<f64, SVector<f64, NODES>> for &Train<'_> {
    fn system(&self, t: f64, y: &SVector<f64, NODES>, dy: &mut SVector<f64, NODES>) {
        let last = self.case.edges.partition_point(|e| e.0.as_secs_f64() <= t);
        let watts = self
            .case
            .edges
            .get(last.wrapping_sub(1))
            .map_or(0.0, |e| e.1);
        let nodes = std::array::from_fn(|i| y[i]);
        let capacity = self.wire.heat_capacity();
        dy.copy_from_slice(
            &self
                .network
                .rate(&nodes, watts * self.wire.wire_share, capacity),
        );
    }
}

/// Calls both of ode_solvers' methods once over a burst. The phase is left out, so that nothing but the edges is
/// hard.
///
/// # Errors
/// A network that cannot be computed.
pub fn measure(findings: &mut Findings) -> Result<(), String> {
    let end = ms(LENGTH_MS);
    let case = Case {
        name: "one call over a burst (a warning)",
        wire: WireParameters {
            latent_heat: 0.0,
            ..WireParameters::FINAL
        },
        edges: Bursts::round_robin(end).edges(),
        end,
        ..Case::round_robin()
    };
    let network = Network::new(&case.wire, &case.skin).map_err(|e| e.to_string())?;
    let train = Train {
        network: &network,
        wire: &case.wire,
        case: &case,
    };
    let times: Vec<u64> = (0..=4 * LENGTH_MS).collect();
    let mut wire = Wire::new(&case.wire, &case.skin, START_C).map_err(|e| e.to_string())?;
    let mut edges = case.edges.iter().peekable();
    let mut truth = Vec::new();
    for quarter in times {
        let at = palpate_emulators::time::Nanos(quarter * 250_000);
        while let Some(&(t, watts)) = edges.next_if(|e| e.0 <= at) {
            wire.set_power(t, watts);
        }
        truth.push((at.as_secs_f64() * 1e3, wire.temperature(at)));
    }
    let mut series = vec![Series {
        name: "from edge to edge".into(),
        points: truth.clone(),
        mark: Mark::Line,
    }];
    let start = SVector::<f64, NODES>::repeat(START_C);
    let length = end.as_secs_f64();
    for tolerance in TOLERANCES {
        let mut eighth = Dop853::new(&train, 0.0, length, 250e-6, start, tolerance, tolerance);
        let mut fifth = Dopri5::from_param(
            &train,
            0.0,
            length,
            250e-6,
            start,
            tolerance,
            tolerance,
            0.9,
            0.04,
            0.2,
            10.0,
            length,
            0.0,
            1_000_000,
            u32::MAX,
            OutputType::Dense,
        );
        let done = [
            (
                "DOP853",
                eighth.integrate().is_ok(),
                eighth.x_out(),
                eighth.y_out(),
            ),
            (
                "DOPRI5",
                fifth.integrate().is_ok(),
                fifth.x_out(),
                fifth.y_out(),
            ),
        ];
        for (name, ended, x, y) in done {
            let points: Vec<_> = x.iter().zip(y).map(|(t, y)| (t * 1e3, y[0])).collect();
            let off = |p: &(f64, f64)| {
                let near = truth.get((p.0 * 4.0).round() as usize);
                near.map_or(0.0, |t| (t.1 - p.1).abs())
            };
            findings.rows.push(Row {
                family: "physics",
                case: case.name.into(),
                method: format!("ode_solvers {name} {tolerance:.0e}"),
                error: if ended {
                    points.iter().map(off).fold(0.0, f64::max)
                } else {
                    f64::NAN
                },
                error_unit: "K, largest",
                median_us: f64::NAN,
                peer: true,
            });
            series.push(Series {
                name: format!("{name}, tolerance {tolerance:.0e}, one call"),
                points,
                mark: Mark::Line,
            });
        }
    }
    let axis = |label: &str| Axis {
        label: label.into(),
        log: false,
    };
    findings.plots.push(Plot {
        name: "hidden-edges".into(),
        title: "a warning: one call of a general solver over a burst".into(),
        words: "Wire temperature in one burst of seven pulses of 124 \u{b5}s. Called once over all of them, a solver with \
                step control does not see the pulses that lie between its steps, and reports success. Restarted at \
                every edge the same solvers agree (the diagrams above)."
            .into(),
        x: axis("time [ms]"),
        y: axis("wire [\u{b0}C]"),
        series,
    });
    Ok(())
}
