//! All integration tests in one binary, to save linking.

#[cfg(test)]
mod allegro;
#[cfg(test)]
mod dbc;
