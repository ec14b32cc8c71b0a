//! Other people's solvers on the same equations, their known traps avoided: they are restarted at every
//! edge, `ode_solvers` with sparse output (its dense output is wrong at the ends of short segments), diffsol with
//! a derivative that is computed anew after the restart.
//!
//! Between two edges the wire's temperature goes one way, so the memory of the hysteresis is that of the
//! segment's start. Kinks of the heat capacity inside a segment are left to the peers' error control.

use std::cell::RefCell;
use std::rc::Rc;

use diffsol::{
    NalgebraLU, NalgebraMat, OdeBuilder, OdeEquations, OdeSolverMethod, OdeSolverProblem,
    OdeSolverStopReason,
};
use ode_solvers::dop853::Dop853 as Integrator;
use ode_solvers::{OutputType, SVector, System};
use palpate_core::physics::WireParameters;
use palpate_emulators::finger::{NODES, Network};
use palpate_emulators::time::Nanos;

use super::methods::Nodes;
use super::train::{Case, START_C};

/// The heat balance while the power is constant, written down plainly.
#[derive(Clone)]
pub struct Balance {
    network: Network,
    /// The same with everything around it at zero: what is left of the balance in its derivative.
    still: Network,
    wire: WireParameters,
    /// Heat into the wire, W.
    watts: f64,
    /// Martensite fraction at the segment's start.
    memory: f64,
}

impl Balance {
    fn new(case: &Case) -> Result<Self, String> {
        let network = Network::new(&case.wire, &case.skin).map_err(|e| e.to_string())?;
        Ok(Self {
            still: Network {
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

    /// Bounds of the fraction at `t` from heating and cooling, and their slopes.
    fn branches(&self, t: f64) -> [(f64, f64); 2] {
        let a = &self.wire.alloy;
        let line = |t: f64, from: f64, to: f64| {
            let x = (to - t) / (to - from);
            let slope = if (0.0..1.0).contains(&x) {
                -1.0 / (to - from)
            } else {
                0.0
            };
            (x.clamp(0.0, 1.0), slope)
        };
        [
            line(t, a.austenite_start_c, a.austenite_finish_c),
            line(t, a.martensite_finish_c, a.martensite_start_c),
        ]
    }

    /// Generalised play: the fraction, and its slope while it follows a branch.
    fn fraction(&self, t: f64) -> (f64, f64) {
        let [heating, cooling] = self.branches(t);
        if self.memory > heating.0 {
            heating
        } else if self.memory < cooling.0 {
            cooling
        } else {
            (self.memory, 0.0)
        }
    }

    fn capacity(&self, t: f64) -> f64 {
        let w = &self.wire;
        w.mass() * (w.specific_heat - w.latent_heat * self.fraction(t).1)
    }

    fn rate(&self, nodes: &Nodes) -> Nodes {
        self.network
            .rate(nodes, self.watts, self.capacity(nodes[0]))
    }

    /// The rate's derivative along `v`: linear but for the kinks of the heat capacity.
    fn along(&self, nodes: &Nodes, v: &Nodes) -> Nodes {
        self.still.rate(v, 0.0, self.capacity(nodes[0]))
    }
}

/// A peer that solves one segment after another.
pub trait Segments {
    /// Solves for `seconds` with the power as it is, from and to `nodes`.
    fn solve(&mut self, balance: &Balance, seconds: f64, nodes: &mut Nodes) -> Result<(), String>;
}

/// Restarts a peer at every edge of a case.
pub fn along(
    case: &Case,
    peer: &mut impl Segments,
    mut seen: Option<&mut Vec<Nodes>>,
) -> Result<(), String> {
    let mut balance = Balance::new(case)?;
    let (mut nodes, mut now) = ([START_C; NODES], Nanos::ZERO);
    for &(at, watts) in case.edges.iter().chain([&(case.end, 0.0)]) {
        if at > now {
            peer.solve(&balance, at.since(now).as_secs_f64(), &mut nodes)?;
            balance.memory = balance.fraction(nodes[0]).0;
            now = at;
        }
        balance.watts = watts * case.wire.wire_share;
        if let Some(seen) = seen.as_deref_mut() {
            seen.push(nodes);
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

const fn peer<Eqn: OdeEquations, S>(
    problem: &OdeSolverProblem<Eqn>,
    balance: Rc<RefCell<Balance>>,
    solver: S,
    order: usize,
) -> Diffsol<'_, Eqn, S> {
    Diffsol {
        problem,
        balance,
        solver,
        order,
    }
}

/// Which of diffsol's methods.
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
    match kind {
        Kind::Bdf => {
            let solver = problem.bdf::<NalgebraLU<f64>>().map_err(fault)?;
            along(case, &mut peer(&problem, balance, solver, 1), seen)
        }
        Kind::Tsit45 => {
            let solver = problem.tsit45().map_err(fault)?;
            along(case, &mut peer(&problem, balance, solver, 4), seen)
        }
    }
}
