//! All integration tests in one binary, to save linking.

// A failed expectation in a test is its message.
#![allow(clippy::unwrap_used, clippy::panic, clippy::print_stdout)]

mod allegro;
mod dbc;
mod driver;
mod faults;
mod hand;
mod pca9685;
mod scans;
mod tidy;
