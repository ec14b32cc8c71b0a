//! The skin as numbers: layouts, frames, the initialiser, the relative frame and taxel health.
//!
//! What belongs here is everything between a taxel reading and the list of taxels in contact. Clustering is
//! [`crate::contact`]'s; bytes on a bus are [`crate::wire`]'s; layout files are `hil`'s.
//!
//! `readings -> ScanAssembler -> Scan -> Initialiser -> RelativeFrame`, with [`health::Monitor`] beside it.
//! Taxels of all modules share one running index: module after module, row-major within a grid.

mod baseline;
pub mod frame;
pub mod health;
pub mod initialiser;
pub mod layout;
mod layout_error;
pub mod relative;

pub use frame::{Reading, Scan, ScanAssembler};
pub use health::{Condition, HealthSettings, HealthSummary, Monitor};
pub use initialiser::{Initialiser, InitialiserError, InitialiserSettings, Phase, ThresholdRule};
pub use layout::{Address, Grid, Layout, LayoutError, Module};
pub use relative::{Axes, FrameError, RelativeFrame};
