//! The projection: from touched skin to felt skin.
//!
//! `taxels -> frames -> relative frame -> contacts -> illusion -> schedule -> guard -> driver`
//!
//! This crate is `no_std`, forbids `unsafe`, performs no I/O and never reads a clock: time comes in as
//! an argument ([`units::Instant`]) and whoever owns time calls the loop. Memory is allocated when
//! things are built and never in the loop. It knows no file or text format; those live in `palpate-hil`.
#![no_std]
#![forbid(unsafe_code)]
// Tests compare floats exactly where exactness is the claim.
#![cfg_attr(test, allow(clippy::float_cmp))]

extern crate alloc;

pub mod bus;
pub mod contact;
pub mod driver;
pub mod guard;
pub mod illusion;
pub mod physics;
pub mod projector;
pub mod random;
pub mod schedule;
pub mod skin;
pub mod texture;
pub mod units;
pub mod vector;
pub mod wire;
