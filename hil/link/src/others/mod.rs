//! Programs beside the two ends: what introduces, lists, records, joins, and makes keys.

pub mod keys;
pub mod list;
pub mod merge;
mod pairs;
pub mod record;
pub mod relay;
