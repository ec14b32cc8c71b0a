//! Firmware images of the driver unit, run by QEMU over this project's emulated chips.
//!
//! [`Guest`] is QEMU and the two pipes of the image's rig. [`Chips`] answers for bus and OE line. [`Lockstep`] adds a host
//! and a network in the guest's own time, so that a run is the same each time. [`Image`] is what a file on the disk says.

mod chips;
mod guest;
mod image;
mod lockstep;

pub use chips::{Chips, Current, Level};
pub use guest::{Guest, Machine, Network};
pub use image::{Image, free_of};
pub use lockstep::{Host, Lockstep};
pub use palpate_image::rig::{LIMITS, WIRES};
