//! Parts that firmware images of the driver unit share, the same on every processor. Watchdog, timer and network differ
//! by processor and stand in the package of its image.
//!
//! [`serve`] is the program of an image. [`Arena`] is its heap, which closes once the unit is built. [`rig`] is the bench
//! of an image that runs in QEMU: emulated chips in another process, reached by semihosting. [`udp`] is a network over any card.
#![no_std]

mod arena;
mod decision;
mod key;
mod register;
pub mod rig;
mod serve;
#[cfg(feature = "udp")]
pub mod udp;

pub use arena::Arena;
pub use decision::{ANSWER, QUESTION, Question, answer};
pub use key::{fingertips, key};
pub use register::Register;
pub use serve::{Awake, Link, Processor, serve};
