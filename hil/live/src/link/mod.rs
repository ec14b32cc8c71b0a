//! A driver unit for its host: the key that both share, and the unit over UDP.

pub mod key;
mod remote;

pub use remote::{RemoteUnit, UnitPlace};
