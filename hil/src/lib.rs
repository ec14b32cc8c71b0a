//! The `hil` library: everything behind the command line.
