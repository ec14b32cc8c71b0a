//! The study of textures: strokes over emulated surfaces, their places and answers in a model one property at a time,
//! the ratings of a simulated panel, and the encoder for other programs.
//!
//! Nothing here writes a file or prints; recordings of real sensors are read. Training is a crate of its own.
#![forbid(unsafe_code)]

pub mod draw;
pub mod explore;
pub mod map;
pub mod onnx;
pub mod panel;
pub mod rebuild;
pub mod response;
pub mod rows;
pub mod world;

/// Rounds to the three decimals of figures; no minus before a zero.
pub fn round(value: f64) -> f64 {
    (value * 1e3).round() / 1e3 + 0.0
}
