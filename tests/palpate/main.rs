//! All integration tests in one binary, to save linking.

mod allegro;
mod dbc;
mod driver;
mod tidy;
