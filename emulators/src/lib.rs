//! Emulated hardware on both ends of the loop, in virtual time only.
//!
//! Nothing here sleeps, reads a clock, opens a file or a socket. Time is an argument or an event queue
//! in integer nanoseconds; a pacer in `palpate-hil` may delay what happens here and never changes it.
//! Every device has a bus face (what a driver sees), a physical face (what a test does to it and reads
//! from it) and room for a fault layer in front.
//!
#![doc = include_str!("../README.md")]
#![forbid(unsafe_code)]

pub mod display;
pub mod haptic;
pub mod motors;
pub mod network;
pub mod person;
pub mod sensor;
pub mod time;
pub mod unit;
pub mod worn;

/// Checks, as this crate is compiled, that the parts of a bench can cross to another thread.
const _: () = {
    const fn crosses<T: Send>() {}
    crosses::<worn::WornDisplay>();
    crosses::<display::i2c::I2cHandle>();
    crosses::<display::i2c::fault::Shared<display::i2c::I2cHandle>>();
    crosses::<sensor::port::HostPort>();
    crosses::<sensor::can::faults::Faulty<sensor::rig::Handle>>();
    crosses::<sensor::EmulatedModule>();
    crosses::<Box<dyn sensor::Touches>>();
    crosses::<sensor::surface::Explorer>();
    crosses::<sensor::surface::SurfaceStrokes>();
    crosses::<person::panel::Panel>();
};
