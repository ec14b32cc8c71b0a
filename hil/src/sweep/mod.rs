//! Tables of many runs as files: one that grows while runs end, and what their figures look like.

pub mod chart;
mod growing;
pub mod page;
mod work;

pub use growing::{Growing, form_of, read_table};
pub use page::{foot, head, page};
pub use work::Work;
