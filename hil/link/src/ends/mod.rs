//! The two ends: a robot's skin that is published, and a wearer's display that renders its frames.

mod answers;
mod bent;
pub mod display;
mod feeling;
pub mod glove;
mod heard;
mod inbox;
mod report;
mod shrunk;
pub mod skin;
mod skins;
mod voice;

pub use inbox::Inbox;
pub use shrunk::{Shrunk, levels};
