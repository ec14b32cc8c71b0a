//! Drivers: guarded updates in, bytes out.

mod actuators;
mod banks;
mod dac7578;
mod look;
mod pca9685;
mod unit;

pub use actuators::{Actuators, ObservedRegisters};
pub use banks::Banks;
pub use look::Seen;
pub use pca9685::{DriverError, Pca9685Bank, Traffic};
pub use unit::{LinkCounts, UnitDriver, UnitFault, UnitSettings};

/// Every channel of a board, a bit each.
const WHOLE: u16 = u16::MAX;
