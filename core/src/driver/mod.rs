//! Drivers: guarded updates in, bytes out.

mod actuators;
mod banks;
mod dac7578;
mod drv2605;
mod haptic_error;
mod look;
mod pca9685;
#[cfg(feature = "unit")]
mod unit;
mod unit_fault;

pub use actuators::{Actuators, Driver};
pub use banks::Banks;
pub use drv2605::{HapticCalibration, HapticChannel, HapticMotor, Haptics};
pub use haptic_error::HapticError;
pub use look::Seen;
pub use pca9685::{DriverError, Pca9685Bank, Traffic};
#[cfg(feature = "unit")]
pub use unit::{LinkCounts, UnitDriver, UnitSettings};
pub use unit_fault::UnitFault;

/// Every channel of a board, a bit each.
const WHOLE: u16 = u16::MAX;
