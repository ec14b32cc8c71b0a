//! What was recorded elsewhere and is read here: raw counts as CSV, CAN buses as candump logs and MCAP.
#![forbid(unsafe_code)]

mod can_log;
mod taxel_csv;

#[cfg(test)]
mod tests;

pub use can_log::{CanRecording, is_can_recording, read_can_recording, write_can_log};
pub use taxel_csv::{Columns, TaxelTable, read_taxel_csv};
