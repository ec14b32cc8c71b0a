//! Programs beside the two ends: what passes on, lists, records, joins, and makes keys.

pub mod keys;
pub mod list;
pub mod merge;
pub mod record;
pub mod relay;
