//! Real recordings.

mod recordings;
