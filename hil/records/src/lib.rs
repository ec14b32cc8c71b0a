//! The canonical trace of a run, and what reads it.
#![forbid(unsafe_code)]

pub mod candump;
pub mod trace;
