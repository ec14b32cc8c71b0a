//! An hour edge by edge and thirty days in closed form, against the same affine map from another library: nalgebra's
//! matrix exponential of both parts of a period, raised to the number of periods by squaring.

use std::time::Duration;

use nalgebra::SMatrix;
use palpate_core::physics::{SkinParameters, WireParameters};
use palpate_emulators::finger::{NODES, Network};
use palpate_emulators::solver::exact::Exact;
use palpate_emulators::solver::{Drive, Solver};
use palpate_emulators::time::Nanos;

use super::methods::Nodes;
use super::train::{PULSE_W, START_C, pwm};
use crate::bench::timing::Race;
use crate::bench::{Findings, Row};

/// Part of the full drive that a wire bears without end, below any transformation.
const PART: f64 = 0.2;
/// The temperatures and a one, so that heat is a column.
const SIDE: usize = NODES + 1;
type Map = SMatrix<f64, SIDE, SIDE>;

/// The state after so many periods.
fn reference(count: u64) -> Result<Nodes, String> {
    let wire = WireParameters::FINAL;
    let network = Network::new(&wire, &SkinParameters::DEFAULT).map_err(|e| e.to_string())?;
    let (period, pulse) = pwm();
    let map = |watts: f64, span: Nanos| {
        let mut rates = Map::zeros();
        let nothing = network.rate(&[0.0; NODES], watts * wire.wire_share, wire.heat_capacity());
        for k in 0..NODES {
            let mut one = [0.0; NODES];
            one[k] = 1.0;
            let at_one = network.rate(&one, watts * wire.wire_share, wire.heat_capacity());
            for i in 0..NODES {
                rates[(i, k)] = at_one[i] - nothing[i];
                rates[(i, NODES)] = nothing[i];
            }
        }
        (rates * span.as_secs_f64()).exp()
    };
    let once = map(0.0, period.since(pulse)) * map(PULSE_W * PART, pulse);
    let (mut power, mut all, mut left) = (once, Map::identity(), count);
    while left > 0 {
        if left % 2 == 1 {
            all *= power;
        }
        power *= power;
        left /= 2;
    }
    Ok(std::array::from_fn(|i| {
        (0..NODES).map(|k| all[(i, k)] * START_C).sum::<f64>() + all[(i, NODES)]
    }))
}

fn drift(solver: &Exact, count: u64) -> Result<f64, String> {
    let truth = reference(count)?;
    let apart = solver
        .nodes()
        .into_iter()
        .zip(truth)
        .map(|(a, b)| (a - b).abs());
    Ok(apart.fold(0.0, f64::max))
}

/// Both lengths.
///
/// # Errors
/// A wire that cannot be computed.
pub fn measure(findings: &mut Findings) -> Result<(), String> {
    let (period, pulse) = pwm();
    let new = Exact::new(&WireParameters::FINAL, &SkinParameters::DEFAULT, START_C);
    let new = new.map_err(|e| e.to_string())?;
    let on = Drive::Power(PULSE_W * PART);
    let periods = |seconds: u64| seconds * 1_000_000_000 / period.0;
    let (hour, month) = (periods(3600), periods(30 * 86_400));
    let walk = || {
        let mut solver = new.clone();
        for i in 0..hour {
            let start = Nanos(i * period.0);
            solver.drive(start, on);
            solver.drive(start + pulse, Drive::Off);
        }
        solver.advance(Nanos(hour * period.0));
        solver
    };
    let jump = || {
        let mut solver = new.clone();
        solver.repeat(&[(Nanos::ZERO, on), (pulse, Drive::Off)], period, month);
        solver
    };
    let errors = [drift(&walk(), hour)?, drift(&jump(), month)?];
    let mut race = Race::default();
    race.enter(|| walk().now());
    race.enter(|| jump().now());
    let samples = race.run(31, Duration::from_secs(2));
    let names = [
        "1 wire, one hour, edge by edge",
        "1 wire, 30 days, closed form",
    ];
    for ((name, error), samples) in names.into_iter().zip(errors).zip(samples) {
        findings.rows.push(Row {
            family: "physics",
            case: name.into(),
            method: "default".into(),
            error,
            error_unit: "K, drift",
            median_us: samples.median(),
            peer: false,
        });
    }
    Ok(())
}
