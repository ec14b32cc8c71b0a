//! Compression of taxels into contacts (thesis chapter 4): locations by weighted K-means, identity from
//! frame to frame, intensity by interpolation, intensity levels.

mod compressor;
mod identity;
mod intensity;
mod kmeans;
mod levels;
mod seed;

pub use compressor::{CompressError, Compressor, Contact, Norm, Settings, Stage};
pub use kmeans::{Outcome, Points, Workspace};
pub use levels::{LevelsError, assign, jnd_levels, optimal_levels};
