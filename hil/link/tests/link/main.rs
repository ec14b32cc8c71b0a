//! Tests of the link: the gate in virtual time, the felt path behind a network, two programs on loopback.

// A failed expectation in a test is its message.
#![allow(clippy::unwrap_used, clippy::panic, clippy::print_stdout)]

mod felt;
mod gate;
mod loopback;
mod weather;
