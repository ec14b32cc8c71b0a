//! The `hil` library: everything behind the command line.

#[cfg(feature = "bench")]
pub mod bench;
pub mod capture;
pub mod cli;
pub mod clock;
pub mod command;
pub mod emulate;
pub mod failure;
pub mod felt;
pub mod output;
pub mod parallel;
pub mod plan;
pub mod record;
pub mod recording;
pub mod review;
pub mod run;
pub mod texture;
pub mod trial;
pub mod watch;
