//! The texture encoder against a plain f64 one, its forms against each other, and hostile numbers.

mod engine;
mod numerics;
