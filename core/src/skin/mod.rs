//! The sensor's side: where the taxels are, how frames become scans, what is a contact, who is ill.

mod health;
mod initialiser;
mod layout;
mod scan;

pub use health::{Health, HealthSummary};
pub use initialiser::{Axes, Initialiser, InitialiserSettings, Phase, Threshold};
pub use layout::{Grid, Layout, LayoutError, Module};
pub use scan::Scan;
