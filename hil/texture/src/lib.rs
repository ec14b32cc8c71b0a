//! The study of textures: strokes over emulated surfaces, where a model puts them and how it answers one property at a
//! time, what a simulated panel says of them, and the encoder for other programs.
//!
//! Nothing here writes a file or prints; recordings of real sensors are read. Training is a crate of its own.
#![forbid(unsafe_code)]

pub mod draw;
pub mod explore;
pub mod map;
pub mod onnx;
pub mod panel;
pub mod response;
pub mod rows;
pub mod world;

/// Three decimals, as figures are told; no minus before a zero.
pub fn round(value: f64) -> f64 {
    (value * 1e3).round() / 1e3 + 0.0
}
