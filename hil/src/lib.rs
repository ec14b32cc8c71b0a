//! The `hil` library: everything behind the command line.

pub mod again;
pub mod capture;
pub mod cli;
pub mod clock;
pub mod command;
pub mod emulate;
pub mod ending;
pub mod history;
pub mod host;
pub mod interfaces;
pub mod link;
pub mod output;
pub mod parallel;
pub mod program;
pub mod progress;
pub mod real;
pub mod record;
pub mod recording;
pub mod review;
pub mod serve;
pub mod sweep;
pub mod telling;
pub mod trial;
pub mod unit;
pub mod views;
pub mod watch;
