//! All integration tests in one binary, to save linking.

mod driver;
mod tidy;
