//! The `hil` library: everything behind the command line.

pub mod files;
