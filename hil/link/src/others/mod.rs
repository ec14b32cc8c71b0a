//! Programs besides the two ends: they introduce, list, record, join, and make keys.

pub mod keys;
pub mod list;
pub mod merge;
mod pairs;
pub mod record;
pub mod relay;
