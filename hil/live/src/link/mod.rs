//! A driver unit as its host meets it: the key that both share, and the unit over UDP.

pub mod key;
mod remote;

pub use remote::{RemoteUnit, UnitPlace};
