//! Tests of the link: the gate in virtual time, the felt path behind a network, programs on loopback, a glove, beside a driver unit,
//! asleep, and with certificates that expire.

// A failed expectation in a test is its message.
#![allow(clippy::unwrap_used, clippy::panic, clippy::print_stdout)]

mod asleep;
mod expiry;
mod felt;
mod gate;
mod glove;
mod loopback;
mod programs;
mod unit;
mod weather;
