//! How temperatures are computed between the edges of the current.
//!
//! [`exact::Exact`] is what the emulator uses. The others exist to be compared with it. All take the same
//! calls: the drive changes at integer times, and nothing is computed until somebody asks.

mod decay;
mod eigen;
pub mod exact;
mod highest;
mod maxima;
pub mod modal;
mod periodic;
mod propagators;
mod step;
pub mod stepped;
pub mod sum;

use crate::finger::NODES;
use crate::time::Nanos;

/// What is done to a wire from some instant on.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Drive {
    /// Nothing flows.
    #[default]
    Off,
    /// Constant current, A.
    Current(f64),
    /// Constant electrical power, W; the wire's share of it is constant too.
    Power(f64),
}

/// One wire on one finger, advanced by some method.
pub trait Solver {
    /// Changes the drive at `at`; earlier than what was already asked for counts as now.
    fn drive(&mut self, at: Nanos, drive: Drive);
    /// Computes up to `to`; does nothing if that is past.
    fn advance(&mut self, to: Nanos);
    /// Temperatures of wire and shells at the time advanced to, degrees C.
    fn nodes(&self) -> [f64; NODES];
    /// Martensite fraction at the time advanced to.
    fn fraction(&self) -> f64;
    /// Hottest the wire has been, degrees C.
    fn wire_peak(&self) -> f64;
}
