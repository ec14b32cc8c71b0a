//! Results held against earlier ones: two summaries or tables, and a folder of summaries over time.

mod difference;
mod objects;
mod pair;
mod tables;
mod trend;

pub use difference::{Compared, Difference, Named, Tolerance};
pub use objects::compare_objects;
pub use pair::page_of_two;
pub use tables::compare_tables;
pub use trend::{Trend, page, trends};
