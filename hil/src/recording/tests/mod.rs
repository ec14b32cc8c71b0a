//! Good, bad and real recordings.

mod bad_csv;
mod recordings;
