//! The projection: from touched skin to felt skin. What belongs here is everything between a taxel reading and a
//! driver's registers, without a clock, I/O, or a file or text format: those are `palpate-hil`'s.
//!
#![cfg_attr(feature = "projector", doc = include_str!("../README.md"))]
#![no_std]
#![forbid(unsafe_code)]
// The loop alone calls some of what it is built on.
#![cfg_attr(not(feature = "projector"), allow(dead_code))]
// Tests compare floats exactly where exactness is the claim.
#![cfg_attr(test, allow(clippy::float_cmp))]

extern crate alloc;

pub mod bus;
pub mod codec;
pub mod contact;
#[cfg(feature = "projector")]
pub mod driver;
#[cfg(feature = "projector")]
pub mod guard;
#[cfg(feature = "projector")]
pub mod illusion;
mod listed;
#[cfg(feature = "projector")]
pub mod peltier;
#[cfg(feature = "projector")]
pub mod physics;
// Its textures share a network between modules by `Arc`, which needs a processor that compares and swaps.
#[cfg(all(feature = "projector", target_has_atomic = "ptr"))]
pub mod projector;
pub mod random;
#[cfg(feature = "projector")]
pub mod render;
#[cfg(feature = "projector")]
pub mod schedule;
pub mod skin;
pub mod statistics;
#[cfg(all(feature = "projector", target_has_atomic = "ptr"))]
pub mod texture;
pub mod units;
pub mod vector;
