//! The driver unit: what a worn microcontroller does between a host's datagrams and the boards. What belongs here is
//! the same in an emulator, a process and an image: link, schedule, guard, boards. No clock, socket or peripheral does.
//!
#![doc = include_str!("../README.md")]
#![no_std]
#![forbid(unsafe_code)]

extern crate alloc;

mod counts;
mod no_pin;
mod phases;
mod schedule;
mod session;
mod settings;
mod unit;
mod warmth;

pub use counts::Counts;
pub use no_pin::NoPin;
pub use settings::{Converters, Settings, SettingsError};
pub use unit::{Datagrams, Unit};
pub use warmth::{Module, NoModule};

#[cfg(test)]
mod tests;
