//! Solvers for the temperatures between the edges of the current.
//!
//! The drive changes at integer times, and [`exact::Exact`] computes nothing until a question or an edge comes.

pub(crate) mod branch;
pub(crate) mod decay;
mod eigen;
pub mod exact;
mod highest;
mod lanes;
mod maxima;
pub mod modal;
pub(crate) mod phase;
mod propagators;
pub mod record;
mod regimes;
pub(crate) mod strain;
pub mod stretch;
mod sum;

/// Drive of a wire from some instant on.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum WireDrive {
    /// A wire without current.
    #[default]
    Off,
    /// Constant current, A.
    Current(f64),
    /// Constant electrical power, W; the wire's share of it is constant too.
    Power(f64),
}
