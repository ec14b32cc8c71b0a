//! Drivers: guarded updates in, bytes out.

mod pca9685;

pub use pca9685::{DriverError, Pca9685Bank, Traffic};
