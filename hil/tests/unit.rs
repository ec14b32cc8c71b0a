//! A driver unit against its host, whatever it is: the same suite on the model in this process and on the process
//! `hil unit`. Another kind of unit, such as an image, is another [`subject::Subject`].

// A failed expectation in a test is its message.
#![allow(clippy::unwrap_used, clippy::panic)]

#[path = "unit/process.rs"]
mod process;
#[path = "unit/subject.rs"]
mod subject;
#[path = "unit/suite.rs"]
mod suite;
