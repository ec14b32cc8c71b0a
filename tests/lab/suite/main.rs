//! The lab suite: `hil emulate` in a process of its own, and programs of other projects as its clients.
//!
//! Needs CAN interfaces, `/dev/uhid` and root, which `ci/lab` gives. Anywhere else every test says that it
//! was skipped. One test after the other (`--test-threads 1`): they share the interfaces.

// A failed expectation in a test is its message.
#![allow(clippy::unwrap_used, clippy::panic, clippy::print_stdout)]

mod bench_faults;
mod can_clients;
mod can_flood;
mod converters;
mod deaths;
mod driver_unit;
mod emulator;
mod fuzz;
mod hand_faults;
mod hands;
mod i2c_clients;
mod interfaces;
mod links;
mod motors;
mod page;
mod records;
mod sja1000;
mod study;
mod tools;
mod trials;
mod ward;
mod whole_loop;
