//! What integration tests and benchmarks share; the tests themselves are in `palpate/`.
#![forbid(unsafe_code)]

pub mod felt;

pub mod reference;
pub mod seeded;
pub mod unit;
