//! Results held against earlier ones: two summaries or tables, and a folder of summaries over time.

mod difference;
mod objects;
mod tables;
mod trend;

pub use difference::{Compared, Difference, Tolerance};
pub use objects::compare_objects;
pub use tables::compare_tables;
pub use trend::{Trend, page, trends};
