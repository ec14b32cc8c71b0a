//! Drivers: guarded updates in, bytes out.

mod banks;
mod look;
mod pca9685;

pub use banks::Banks;
pub use look::Seen;
pub use pca9685::{DriverError, Pca9685Bank, Traffic};
