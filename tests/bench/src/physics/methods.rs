//! The methods that are compared: ours and the peers, each along one train of pulses.

use palpate_emulators::display::wire::Wire;

use super::peers::{self, Dop853, Kind};
use super::train::{Case, Nodes, START_C};

/// Methods that compute a case.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Method {
    /// The program's method: exact from edge to edge.
    Default,
    /// ode_solvers, DOP853, at this relative tolerance.
    Dop853(f64),
    /// One of diffsol's, at this relative tolerance.
    Diffsol(Kind, f64),
}

impl Method {
    /// Name of the method without tolerance: points of one name make a line in a diagram.
    pub const fn family(&self) -> &'static str {
        match self {
            Self::Default => "default",
            Self::Dop853(_) => "ode_solvers DOP853",
            Self::Diffsol(Kind::Bdf, _) => "diffsol BDF",
            Self::Diffsol(Kind::Tsit45, _) => "diffsol Tsit45",
        }
    }

    /// Name of the method in the table.
    pub fn name(&self) -> String {
        match self {
            Self::Default => "default".into(),
            Self::Dop853(tolerance) | Self::Diffsol(_, tolerance) => {
                format!("{} {tolerance:.0e}", self.family())
            }
        }
    }

    /// Computes a case; `seen` gets the node temperatures at every edge and at the end.
    ///
    /// # Errors
    /// What the method says when it cannot go on.
    pub fn run(&self, case: &Case, seen: Option<&mut Vec<Nodes>>) -> Result<(), String> {
        match *self {
            Self::Default => default(case, seen),
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
