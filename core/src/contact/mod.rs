//! Compression of taxels into contacts (thesis chapter 4): the places of touch, and their strengths.
//!
//! The module holds clustering, interpolation, intensity levels and identity over time. [`crate::skin`] finds the taxels
//! in contact, and [`crate::illusion`] makes contacts felt.
//!
//! ```
//! use palpate_core::contact::{Compressor, Settings};
//! use palpate_core::skin::{Axes, Layout, Module, RelativeFrame};
//!
//! let layout = Layout::single(Module::grid("pad", 4, 4, 4.7).unwrap()).unwrap();
//! let mut frame = RelativeFrame::new(&layout);
//! let mut compressor = Compressor::new(&layout, Settings::default()).unwrap();
//! let mut differences = [[0.0; 3]; 16];
//! (differences[5][2], differences[6][2]) = (300.0, 100.0);
//! frame.load(&differences, Axes::XYZ, 50.0).unwrap();
//! let contacts = compressor.compress(&frame).unwrap();
//! assert_eq!(contacts.len(), 1);
//! assert!((contacts[0].place.x - -1.175).abs() < 1e-5); // a quarter of the way from taxel 5 to 6
//! ```

mod along;
mod compressor;
mod few;
mod found;
mod group;
mod identity;
mod interpolate;
pub mod kmeans;
pub mod levels;
mod passes;
mod settings;
mod vectors;
mod weights;

pub use compressor::Compressor;
pub use found::{Contact, Work};
pub use group::Group;
pub use kmeans::{KMeans, Points, Stop};
pub use levels::{LevelError, LevelSolver, LevelTable};
pub use settings::{Levels, Norm, Scope, Settings, SettingsError};
pub use vectors::VectorTable;
