//! All integration tests in one binary, to save linking.
mod pca9685;
