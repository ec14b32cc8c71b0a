//! The `hil` program.

fn main() {}
