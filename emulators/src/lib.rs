//! Emulated hardware on both ends of the loop, in virtual time only.
//!
//! Nothing here sleeps, reads a clock, opens a file or a socket. Time is an argument or an event queue
//! in integer nanoseconds; a pacer in `palpate-hil` may delay what happens here and never changes it.
//! Every device has a bus face (what a driver sees), a physical face (what a test does to it and reads
//! from it) and room for a fault layer in front.
#![forbid(unsafe_code)]

pub mod amplifier;
pub mod board;
pub mod can;
pub mod display;
pub mod finger;
pub mod i2c;
pub mod panel;
pub mod pca9685;
pub mod perceiver;
pub mod receptors;
pub mod rig;
pub mod skin;
pub mod solver;
pub mod surface;
pub mod time;
pub mod touching;
pub mod wire;

#[cfg(test)]
mod thermal_tests;
