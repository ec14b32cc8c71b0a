//! A classic CAN segment in virtual time: bit-true lengths, arbitration, load, error confinement.

mod bits;
pub mod faults;
mod node;
mod segment;

#[cfg(test)]
mod tests;

pub use node::{Confinement, Filter, NodeConfig, NodeId, Order, SendError};
pub use segment::{CanSegment, ErrorClass, Statistics};
