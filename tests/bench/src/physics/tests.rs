//! The methods that are compared compute the same thing; long runs against an independent reference; and the trap that
//! the exact solver was built around.

use nalgebra::SMatrix;
use ode_solvers::dop853::Dop853 as Integrator;
use ode_solvers::{SVector, System};
use palpate_core::physics::{TissueParameters, WireParameters};
use palpate_emulators::display::finger::{NODES, ThermalNetwork};
use palpate_emulators::display::solver::WireDrive;
use palpate_emulators::display::solver::exact::Exact;
use palpate_emulators::time::Nanos;

use super::methods::Method;
use super::peers::Kind;
use super::train::{Bursts, Case, Nodes, PULSE_W, START_C, WIRE, ms, pwm};

/// Two bursts with a pause between them: the wire transforms in each.
fn course(method: Method) -> Vec<Nodes> {
    let end = ms(600);
    let case = Case {
        edges: Bursts::round_robin(end).edges(),
        end,
        ..Case::round_robin()
    };
    let mut seen = Vec::new();
    method.run(&case, Some(&mut seen)).unwrap();
    seen
}

#[test]
fn every_method_comes_near_the_exact_solver() {
    let exact = course(Method::Default);
    let hottest = exact.iter().map(|nodes| nodes[0]).fold(0.0, f64::max);
    assert!(hottest > 60.0, "{hottest} C");
    for method in [
        Method::Dop853(1e-9),
        Method::Diffsol(Kind::Bdf, 1e-9),
        Method::Diffsol(Kind::Tsit45, 1e-9),
    ] {
        let other = course(method);
        assert_eq!(other.len(), exact.len());
        let pairs = exact.iter().flatten().zip(other.iter().flatten());
        let apart = pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        assert!(apart < 1e-4, "{}: {apart} K apart", method.name());
    }
}

/// Part of the full drive that a wire bears without end, below any transformation.
const PART: f64 = 0.2;
/// The temperatures and a one, so that heat is a column.
const SIDE: usize = NODES + 1;
type Map = SMatrix<f64, SIDE, SIDE>;

/// The state after so many periods by the same affine map from another library: nalgebra's matrix exponential of both
/// parts of a period, raised to the number of periods by squaring.
fn reference(count: u64) -> Nodes {
    let wire = WIRE;
    let network = ThermalNetwork::new(&wire, &TissueParameters::DEFAULT).unwrap();
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
    std::array::from_fn(|i| {
        (0..NODES).map(|k| all[(i, k)] * START_C).sum::<f64>() + all[(i, NODES)]
    })
}

fn drift(solver: &Exact, count: u64) -> f64 {
    let truth = reference(count);
    let apart = solver
        .nodes()
        .into_iter()
        .zip(truth)
        .map(|(a, b)| (a - b).abs());
    apart.fold(0.0, f64::max)
}

#[test]
fn an_hour_does_not_drift() {
    let (period, pulse) = pwm();
    let mut walked = Exact::new(&WIRE, &TissueParameters::DEFAULT, START_C).unwrap();
    let on = WireDrive::Power(PULSE_W * PART);
    let hour = 3600 * 1_000_000_000 / period.0;
    for i in 0..hour {
        let start = Nanos(i * period.0);
        walked.drive(start, on);
        walked.drive(start + pulse, WireDrive::Off);
    }
    walked.advance(Nanos(hour * period.0));
    let drift = drift(&walked, hour);
    assert!(drift < 1e-6, "{drift} K");
}

/// A whole train as one right-hand side: the power is looked up by time.
struct Train<'a> {
    network: &'a ThermalNetwork,
    case: &'a Case,
}

impl System<f64, SVector<f64, NODES>> for &Train<'_> {
    fn system(&self, t: f64, y: &SVector<f64, NODES>, dy: &mut SVector<f64, NODES>) {
        let edges = &self.case.edges;
        let last = edges.partition_point(|e| e.0.as_secs_f64() <= t);
        let watts = edges.get(last.wrapping_sub(1)).map_or(0.0, |e| e.1);
        let (nodes, wire) = (std::array::from_fn(|i| y[i]), &self.case.wire);
        let heat = watts * wire.wire_share;
        dy.copy_from_slice(&self.network.rate(&nodes, heat, wire.heat_capacity()));
    }
}

/// The phase is left out, so that nothing but the edges is hard.
#[test]
fn one_call_of_a_general_solver_over_a_burst_misses_its_pulses_and_reports_success() {
    let end = ms(200);
    let case = Case {
        wire: WireParameters {
            latent_heat: 0.0,
            ..WIRE
        },
        edges: Bursts::round_robin(end).edges(),
        end,
        ..Case::round_robin()
    };
    let mut truth = Vec::new();
    Method::Default.run(&case, Some(&mut truth)).unwrap();
    let hottest = truth.iter().map(|nodes| nodes[0]).fold(0.0, f64::max);
    let network = ThermalNetwork::new(&case.wire, &case.skin).unwrap();
    let train = Train {
        network: &network,
        case: &case,
    };
    for tolerance in [1e-3, 1e-5, 1e-7] {
        let (start, length) = (SVector::repeat(START_C), end.as_secs_f64());
        let mut method = Integrator::new(&train, 0.0, length, 250e-6, start, tolerance, tolerance);
        method.integrate().unwrap();
        let found = method.y_out().iter().map(|y| y[0]).fold(0.0, f64::max);
        assert!(
            (found - hottest).abs() > 10.0,
            "{tolerance}: {found} of {hottest} C"
        );
    }
}
