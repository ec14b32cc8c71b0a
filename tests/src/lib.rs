//! What integration tests and benchmarks share; the tests themselves are in `palpate/`.

#[cfg(target_os = "linux")]
pub mod fake_bench;
pub mod felt;

pub mod reference;
pub mod seeded;
pub mod unit;
