//! The texture model as a file, recordings as its input, and the way out to other programs.

pub mod draw;
pub mod explore;
pub mod map;
mod model;
pub mod onnx;
pub mod panel;
pub mod reference;
mod rows;
pub mod seeded;

pub use model::TextureModel;
pub use rows::Rows;
