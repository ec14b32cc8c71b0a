//! The projection: from touched skin to felt skin. What belongs here is everything between a taxel reading and a
//! driver's registers, without a clock, I/O, or a file or text format: those are `palpate-hil`'s.
//!
#![doc = include_str!("../README.md")]
#![no_std]
#![forbid(unsafe_code)]
// Tests compare floats exactly where exactness is the claim.
#![cfg_attr(test, allow(clippy::float_cmp))]

extern crate alloc;

pub mod bus;
pub mod codec;
pub mod contact;
pub mod driver;
pub mod guard;
pub mod illusion;
pub mod peltier;
pub mod physics;
// Its textures share a network between modules by `Arc`, which needs a processor that compares and swaps.
#[cfg(target_has_atomic = "ptr")]
pub mod projector;
pub mod random;
pub mod render;
pub mod schedule;
pub mod skin;
#[cfg(target_has_atomic = "ptr")]
pub mod texture;
pub mod units;
pub mod vector;
