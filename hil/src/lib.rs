//! The `hil` library: everything behind the command line.

pub mod cli;
pub mod command;
pub mod history;
pub mod program;
pub mod reproduce;
pub mod review;
pub mod study;
pub mod sweep;
pub mod trial;
