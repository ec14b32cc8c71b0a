//! The skin itself: what a touch does to the counts of a module's taxels.

mod mechanics;
mod module;

pub use mechanics::{Mechanics, Touch, Touches};
pub use module::{Generation, Module, ModuleConfig, grid};
