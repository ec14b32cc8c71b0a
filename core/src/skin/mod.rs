//! The skin as numbers: layouts, scans, the baseline, the relative frame and taxel health.
//!
//! The module holds everything between a taxel reading and the list of taxels in contact. Clustering is
//! [`crate::contact`]'s; bytes on a bus are [`crate::codec`]'s; layout files are `hil`'s.
//!
//! `SkinSource -> ModuleScan -> Scan -> Baseline -> RelativeFrame`, with [`health::Monitor`] beside it.
//! Taxels of all modules share one running index: module after module, row-major within a grid.

pub mod baseline;
mod baseline_settings;
pub mod health;
pub mod layout;
mod layout_error;
mod reference;
pub mod relative;
mod rest;
mod scan;
mod seams;
mod sense;
mod source;
mod speakers;
mod together;
pub mod uskin;

pub use baseline::{Baseline, BaselineError, BaselinePhase, BaselineSettings, ThresholdRule};
pub use health::{Condition, HealthSettings, HealthSummary, Monitor};
pub use layout::{Address, Grid, Layout, LayoutError, Module, Protocol};
pub use relative::{Axes, FrameError, RelativeFrame};
pub use scan::{Scan, WrongLength};
pub use seams::Seam;
pub use sense::Sense;
pub use source::{ModuleScan, ScanError, SkinSource, TakeScan};
pub use uskin::CanSkin;
