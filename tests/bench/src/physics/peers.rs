//! The solvers of other projects on the same equations, their known traps avoided: they are restarted at every
//! edge, `ode_solvers` with sparse output (its dense output is wrong at the ends of short segments), diffsol with
//! a derivative that is computed anew after the restart.
//!
//! Their first unknown is the wire's heat content, not its temperature: T + L/c (1 - xi), K. In the temperature the heat
//! capacity jumps where a transformation begins, and a band narrower than a step is stepped over whatever the tolerance
//! (14 K off in phase-cycling, by every explicit method). In the heat content there is nothing to step over: the rate
//! has kinks, left to the peers' error control.
//!
//! Between two edges the wire's temperature goes one way, so the memory of the hysteresis is that of the
//! segment's start.

use std::cell::RefCell;
use std::rc::Rc;

use diffsol::{
    NalgebraLU, NalgebraMat, OdeBuilder, OdeEquations, OdeSolverMethod, OdeSolverProblem,
    OdeSolverStopReason,
};
use ode_solvers::dop853::Dop853 as Integrator;
use ode_solvers::{OutputType, SVector, System};
use palpate_core::physics::WireParameters;
use palpate_emulators::display::finger::{NODES, ThermalNetwork};
use palpate_emulators::time::Nanos;

use super::train::{Case, Nodes, START_C};

/// The heat balance while the power is constant, written down plainly.
#[derive(Clone)]
pub struct Balance {
    network: ThermalNetwork,
    /// The network with everything around it at zero: the part of the balance that is left in its derivative.
    still: ThermalNetwork,
    wire: WireParameters,
    /// Heat into the wire, W.
    watts: f64,
    /// Martensite fraction at the segment's start.
    memory: f64,
}

impl Balance {
    fn new(case: &Case) -> Result<Self, String> {
        let network = ThermalNetwork::new(&case.wire, &case.skin).map_err(|e| e.to_string())?;
        Ok(Self {
            still: ThermalNetwork {
                air_c: 0.0,
                ends_c: 0.0,
                body_c: 0.0,
                ..network.clone()
            },
            network,
            wire: case.wire,
            watts: 0.0,
            memory: 1.0,
        })
    }

    /// Temperature that all of the latent heat counts for, K.
    fn latent(&self) -> f64 {
        self.wire.latent_heat / self.wire.specific_heat
    }

    /// Generalised play: temperature and fraction at a heat content, and the temperature's change with it.
    fn wire_at(&self, content: f64) -> (f64, f64, f64) {
        let a = &self.wire.alloy;
        let (latent, memory) = (self.latent(), self.memory);
        let resting = content - latent * (1.0 - memory);
        // Heating from this memory transforms from here on, cooling below there.
        let upper = a.austenite_finish_c - memory * (a.austenite_finish_c - a.austenite_start_c);
        let lower = a.martensite_start_c - memory * (a.martensite_start_c - a.martensite_finish_c);
        let branch = if memory > 0.0 && resting > upper {
            (upper, a.austenite_finish_c, memory)
        } else if memory < 1.0 && resting < lower {
            (lower, a.martensite_finish_c, memory - 1.0)
        } else {
            return (resting, memory, 1.0);
        };
        // From `begin` to `end` the fraction falls by `change` (or rises), and the heat content is linear.
        let (begin, end, change) = branch;
        let per_kelvin = change / (end - begin);
        let slope = 1.0 / (1.0 + latent * per_kelvin);
        let t = begin + (resting - begin) * slope;
        if (end - begin) * (end - t) > 0.0 {
            (t, memory - per_kelvin * (t - begin), slope)
        } else {
            (resting - latent * change, memory - change, 1.0)
        }
    }

    /// The temperatures of a state.
    fn temperatures(&self, state: &Nodes) -> Nodes {
        let mut nodes = *state;
        nodes[0] = self.wire_at(state[0]).0;
        nodes
    }

    fn rate(&self, state: &Nodes) -> Nodes {
        let capacity = self.wire.heat_capacity();
        self.network
            .rate(&self.temperatures(state), self.watts, capacity)
    }

    /// The rate's derivative along `v`: linear but for the kinks.
    fn along(&self, state: &Nodes, v: &Nodes) -> Nodes {
        let mut v = *v;
        v[0] *= self.wire_at(state[0]).2;
        self.still.rate(&v, 0.0, self.wire.heat_capacity())
    }
}

/// A peer that solves one segment after another.
pub trait Segments {
    /// Solves for `seconds` with the power as it is, from and to `nodes`, heat content first.
    fn solve(&mut self, balance: &Balance, seconds: f64, nodes: &mut Nodes) -> Result<(), String>;
}

/// Restarts a peer at every edge of a case.
pub fn along(
    case: &Case,
    peer: &mut impl Segments,
    mut seen: Option<&mut Vec<Nodes>>,
) -> Result<(), String> {
    let mut balance = Balance::new(case)?;
    // All martensite: no latent heat in it.
    let (mut state, mut now) = ([START_C; NODES], Nanos::ZERO);
    for &(at, watts) in case.edges.iter().chain([&(case.end, 0.0)]) {
        if at > now {
            peer.solve(&balance, at.since(now).as_secs_f64(), &mut state)?;
            balance.memory = balance.wire_at(state[0]).1;
            now = at;
        }
        balance.watts = watts * case.wire.wire_share;
        if let Some(seen) = seen.as_deref_mut() {
            seen.push(balance.temperatures(&state));
        }
    }
    Ok(())
}

/// ode_solvers, DOP853.
pub struct Dop853 {
    tolerance: f64,
}

impl Dop853 {
    /// At this relative tolerance; the absolute one is a tenth of it, K.
    pub const fn new(tolerance: f64) -> Self {
        Self { tolerance }
    }
}

impl System<f64, SVector<f64, NODES>> for &Balance {
    fn system(&self, _: f64, y: &SVector<f64, NODES>, dy: &mut SVector<f64, NODES>) {
        let nodes = std::array::from_fn(|i| y[i]);
        dy.copy_from_slice(&self.rate(&nodes));
    }
}

impl Segments for Dop853 {
    fn solve(&mut self, balance: &Balance, seconds: f64, nodes: &mut Nodes) -> Result<(), String> {
        let start = SVector::from_column_slice(nodes);
        let mut method = Integrator::from_param(
            balance,
            0.0,
            seconds,
            seconds,
            start,
            self.tolerance,
            self.tolerance * 0.1,
            0.9,
            0.0,
            0.333,
            6.0,
            seconds,
            0.0,
            1_000_000,
            u32::MAX, // no test for stiffness: it would end the run
            OutputType::Sparse,
        );
        method.integrate().map_err(|e| e.to_string())?;
        let end = method.y_out().last().ok_or("no output")?;
        nodes.copy_from_slice(end.as_slice());
        Ok(())
    }
}

/// One of diffsol's methods with the equations it solves.
struct Diffsol<'a, Eqn: OdeEquations, S> {
    problem: &'a OdeSolverProblem<Eqn>,
    balance: Rc<RefCell<Balance>>,
    solver: S,
    order: usize,
}

impl<'a, Eqn, S> Segments for Diffsol<'a, Eqn, S>
where
    Eqn: OdeEquations<T = f64, V = diffsol::NalgebraVec<f64>, C = diffsol::NalgebraContext> + 'a,
    S: OdeSolverMethod<'a, Eqn>,
{
    fn solve(&mut self, balance: &Balance, seconds: f64, nodes: &mut Nodes) -> Result<(), String> {
        *self.balance.borrow_mut() = balance.clone();
        let problem = self.problem;
        let rate = balance.rate(nodes);
        let mut state = self.solver.state_mut();
        *state.t = 0.0;
        for i in 0..NODES {
            state.y[i] = nodes[i];
            state.dy[i] = rate[i];
        }
        state.set_step_size(
            problem.h0,
            &problem.atol,
            problem.rtol,
            &problem.eqn,
            self.order,
        );
        let fault = |e: diffsol::error::DiffsolError| e.to_string();
        self.solver.set_stop_time(seconds).map_err(fault)?;
        while self.solver.step().map_err(fault)? != OdeSolverStopReason::TstopReached {}
        let end = self.solver.state().y;
        for i in 0..NODES {
            nodes[i] = end[i];
        }
        Ok(())
    }
}

/// Methods of diffsol.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// Backward differentiation of variable order, dense LU.
    Bdf,
    /// Explicit Runge-Kutta of order five.
    Tsit45,
}

/// A case by diffsol.
///
/// # Errors
/// What diffsol says.
pub fn diffsol(
    case: &Case,
    kind: Kind,
    tolerance: f64,
    seen: Option<&mut Vec<Nodes>>,
) -> Result<(), String> {
    let balance = Rc::new(RefCell::new(Balance::new(case)?));
    let (rhs, jacobian) = (Rc::clone(&balance), Rc::clone(&balance));
    let nodes = |y: &[f64]| -> Nodes { std::array::from_fn(|i| y[i]) };
    let mut problem = OdeBuilder::<NalgebraMat<f64>>::new()
        .rtol(tolerance)
        .atol([tolerance * 0.1])
        .rhs_implicit(
            move |y, _, _, dy| dy.copy_from_slice(&rhs.borrow().rate(&nodes(y))),
            move |y, _, _, v, out| {
                out.copy_from_slice(&jacobian.borrow().along(&nodes(y), &nodes(v)));
            },
        )
        .init(|_, _, y| y.fill(START_C), NODES)
        .build()
        .map_err(|e| e.to_string())?;
    // Every edge and every kink costs a few: they are counted over the whole life of a solver.
    problem.ode_options.max_nonlinear_solver_failures = 1_000_000;
    problem.ode_options.max_error_test_failures = 1_000_000;
    problem.ode_options.min_timestep = 1e-18;
    let fault = |e: diffsol::error::DiffsolError| e.to_string();
    let problem = &problem;
    match kind {
        Kind::Bdf => {
            let mut peer = Diffsol {
                solver: problem.bdf::<NalgebraLU<f64>>().map_err(fault)?,
                order: 1,
                problem,
                balance,
            };
            along(case, &mut peer, seen)
        }
        Kind::Tsit45 => {
            let mut peer = Diffsol {
                solver: problem.tsit45().map_err(fault)?,
                order: 4,
                problem,
                balance,
            };
            along(case, &mut peer, seen)
        }
    }
}
