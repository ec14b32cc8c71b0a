//! The program `hil` as the console script of the wheel.

use std::ffi::OsString;

use pyo3::prelude::*;

/// Runs a command line, the program's name first, and returns the exit status. `again` are the words that start the
/// program in a process of its own.
#[pyfunction]
pub fn main(py: Python<'_>, line: Vec<OsString>, again: Vec<OsString>) -> u8 {
    py.detach(|| palpate_hil::program::main(line, Some(again)))
}
