//! A whole run, for comparisons of bits: digests and the schedule.

use palpate_files::Setup;
use palpate_records::contacts_csv::write_table;
use palpate_records::digest::{contacts_digest, schedule_digest, trace_digest};
use palpate_records::schedule::write_schedule;
use palpate_run::{Failure, Input};
use serde::Serialize;

/// Digests and records of a run.
#[derive(Debug, Serialize)]
pub struct Digests {
    /// Digest of the whole trace.
    trace: String,
    /// Digest of taxels, frames, contacts and truth.
    contacts: String,
    /// Digest of the stimuli that were sent to the boards.
    schedule: String,
    /// The schedule itself, JSON Lines.
    lines: String,
    /// The contacts themselves, CSV.
    table: String,
}

/// Runs a setup's scene.
///
/// # Errors
/// The failure that ends the run.
pub fn run(setup: &Setup, seed: u64) -> Result<Digests, Failure> {
    let trace = palpate_run::run(setup, &Input::Scene, seed)?.trace;
    let (mut lines, mut table) = (Vec::new(), Vec::new());
    let written = write_schedule(&trace, &mut lines).and_then(|()| write_table(&trace, &mut table));
    written.map_err(|e| Failure::Device(format!("the records: {e}")))?;
    Ok(Digests {
        trace: trace_digest(&trace),
        contacts: contacts_digest(&trace),
        schedule: schedule_digest(&trace),
        lines: text(&lines),
        table: text(&table),
    })
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}
