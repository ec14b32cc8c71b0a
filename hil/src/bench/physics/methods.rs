//! The methods that are compared: ours and the peers, each along one train of pulses.

use palpate_emulators::finger::NODES;
use palpate_emulators::solver::stepped::{Method as Stepping, Stepped};
use palpate_emulators::solver::{Drive, Solver};
use palpate_emulators::time::Nanos;
use palpate_emulators::wire::Wire;

use super::peers::{self, Dop853, Kind};
use super::train::{Case, START_C};

/// Node temperatures, degrees C.
pub type Nodes = [f64; NODES];

/// How a case is computed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Method {
    /// What the program uses: exact from edge to edge.
    Default,
    /// Ours for comparison: a fixed longest step.
    Stepped(Stepping, Nanos),
    /// ode_solvers, DOP853, at this relative tolerance.
    Dop853(f64),
    /// One of diffsol's, at this relative tolerance.
    Diffsol(Kind, f64),
}

impl Method {
    /// Its name without tolerance or step: points of one name make a line in a diagram.
    pub const fn family(&self) -> &'static str {
        match self {
            Self::Default => "default",
            Self::Stepped(Stepping::Euler, _) => "Euler",
            Self::Stepped(Stepping::Rk4, _) => "RK4",
            Self::Stepped(Stepping::CycleAveraged, _) => "cycle-averaged",
            Self::Dop853(_) => "ode_solvers DOP853",
            Self::Diffsol(Kind::Bdf, _) => "diffsol BDF",
            Self::Diffsol(Kind::Tsit45, _) => "diffsol Tsit45",
        }
    }

    /// Its name in the table.
    pub fn name(&self) -> String {
        match self {
            Self::Default => "default".into(),
            Self::Stepped(_, step) => format!("{} {} us", self.family(), step.as_micros()),
            Self::Dop853(tolerance) | Self::Diffsol(_, tolerance) => {
                format!("{} {tolerance:.0e}", self.family())
            }
        }
    }

    /// Whether it is somebody else's.
    pub const fn is_peer(&self) -> bool {
        matches!(self, Self::Dop853(_) | Self::Diffsol(..))
    }

    /// Computes a case; `seen` gets the node temperatures at every edge and at the end.
    ///
    /// # Errors
    /// What the method says when it cannot go on.
    pub fn run(&self, case: &Case, seen: Option<&mut Vec<Nodes>>) -> Result<(), String> {
        match *self {
            Self::Default => default(case, seen),
            Self::Stepped(method, step) => stepped(case, method, step, seen),
            Self::Dop853(tolerance) => peers::along(case, &mut Dop853::new(tolerance), seen),
            Self::Diffsol(kind, tolerance) => peers::diffsol(case, kind, tolerance, seen),
        }
    }
}

fn default(case: &Case, mut seen: Option<&mut Vec<Nodes>>) -> Result<(), String> {
    let mut wire = Wire::new(&case.wire, &case.skin, START_C).map_err(|e| e.to_string())?;
    for &(at, watts) in &case.edges {
        wire.set_power(at, watts);
        if let Some(seen) = seen.as_deref_mut() {
            seen.push(wire.solver().nodes());
        }
    }
    wire.advance(case.end);
    if let Some(seen) = seen {
        seen.push(wire.solver().nodes());
    }
    Ok(())
}

fn stepped(
    case: &Case,
    method: Stepping,
    step: Nanos,
    mut seen: Option<&mut Vec<Nodes>>,
) -> Result<(), String> {
    let made = Stepped::new(&case.wire, &case.skin, START_C, method, step);
    let mut solver = made.map_err(|e| e.to_string())?;
    for &(at, watts) in &case.edges {
        solver.drive(
            at,
            if watts > 0.0 {
                Drive::Power(watts)
            } else {
                Drive::Off
            },
        );
        if let Some(seen) = seen.as_deref_mut() {
            seen.push(solver.nodes());
        }
    }
    solver.advance(case.end);
    if let Some(seen) = seen {
        seen.push(solver.nodes());
    }
    Ok(())
}
