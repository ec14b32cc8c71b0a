//! Bytes only: what stands on the buses. Used by both ends, so an emulator and a driver cannot
//! disagree about a register by accident of two tables.

pub mod can;
#[cfg(feature = "projector")]
pub mod dac7578;
#[cfg(feature = "projector")]
pub mod drv2605;
#[cfg(feature = "unit")]
pub mod link;
pub mod mtb;
#[cfg(feature = "projector")]
pub mod pca9685;
#[cfg(feature = "projector")]
pub mod tca9548a;
pub mod uskin;
