//! The canonical trace of a run, and what reads it.
//!
//! A renderer is a pure function of [`trace::Trace`]: it opens no file and knows no clock, so any two
//! of them tell the same story. Texts are built from integers; only the report's pictures use floats.
#![forbid(unsafe_code)]

pub mod bursts;
pub mod candump;
pub mod contacts_csv;
pub mod damage;
pub mod diff;
pub mod digest;
pub mod felt;
pub mod figures;
mod fixed;
pub mod frame_time;
pub mod i2c;
pub mod json;
pub mod margin;
pub mod mcap;
pub mod measure;
pub mod model;
pub mod readings;
pub mod report;
pub mod runs;
pub mod schedule;
pub mod story;
pub mod table;
pub mod table_schema;
pub mod trace;
pub mod vcd;
pub mod verdict;
pub mod wav;
pub mod words;

#[cfg(test)]
#[path = "synthetic_tests.rs"]
mod synthetic;
