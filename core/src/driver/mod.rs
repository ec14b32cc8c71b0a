//! Drivers: guarded updates in, bytes out.

mod actuators;
mod audio;
mod audio_fault;
mod banks;
mod dac7578;
mod haptic_fault;
mod haptic_look;
mod haptics;
mod look;
mod pca9685;
#[cfg(feature = "unit")]
mod unit;
mod unit_fault;

pub use actuators::{Actuators, Driver};
pub use audio::{Audio, AudioPlan, AudioSink, FULL_SCALE};
pub use audio_fault::{AudioFault, AudioPlanError};
pub use banks::Banks;
pub use haptic_fault::{HapticFault, HapticPlanError};
pub use haptics::{HapticCalibration, HapticChannel, HapticMotor, Haptics};
pub use look::Seen;
pub use pca9685::{DriverError, Pca9685Bank, Traffic};
#[cfg(feature = "unit")]
pub use unit::{LinkCounts, UnitDriver, UnitSettings};
pub use unit_fault::UnitFault;

/// Every channel of a board, a bit each.
const WHOLE: u16 = u16::MAX;
