//! The `hil` library: everything behind the command line.

#[cfg(feature = "bench")]
pub mod bench;
pub mod cli;
pub mod clock;
pub mod command;
pub mod failure;
pub mod files;
pub mod output;
pub mod parallel;
pub mod plan;
pub mod run;
