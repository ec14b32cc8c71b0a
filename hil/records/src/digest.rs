//! The trace as lines of JSON, and SHA-256 over them: what "byte-identical runs" means.
//!
//! Integers and words alone, fields in the order of their declaration, a line per event, so two different traces never
//! share their bytes.

use crate::trace::{Event, Trace, VERSION, sort_by_time};
use serde::Serialize;
use sha2::{Digest, Sha256};

/// First 16 hex digits of the SHA-256 over the whole trace: header, events and ledger.
pub fn trace_digest(trace: &Trace) -> String {
    let mut sink = Sink::default();
    sink.add(&VERSION);
    sink.add(&trace.header);
    trace.events.iter().for_each(|event| sink.add(event));
    sink.add(&trace.ledger);
    sink.finish()
}

/// First 16 hex digits of the SHA-256 over taxels, frames, contacts
/// and truth alone: a change behind the compression leaves it.
pub fn contacts_digest(trace: &Trace) -> String {
    let mut sink = Sink::default();
    sink.add(&trace.header.taxels);
    let sensed = trace
        .events
        .iter()
        .filter(|event| matches!(event, Event::Frame(_) | Event::Contact(_) | Event::Truth(_)));
    sensed.for_each(|event| sink.add(event));
    sink.finish()
}

/// First 16 hex digits of the SHA-256 over the commands to the boards alone: a change of a physical model leaves it.
pub fn schedule_digest(trace: &Trace) -> String {
    let mut digest = ScheduleDigest::default();
    digest.add(&trace.events, u64::MAX);
    digest.finish()
}

/// [`schedule_digest`] of a run whose events are not kept.
#[derive(Clone, Debug, Default)]
pub struct ScheduleDigest {
    sink: Sink,
    /// Events that an earlier one may still precede.
    waiting: Vec<Event>,
}

impl ScheduleDigest {
    /// Adds the next events, in the order in which they were noticed. None that comes later is older than `until_ns`.
    pub fn add(&mut self, events: &[Event], until_ns: u64) {
        let Self { sink, waiting } = self;
        let sent = events.iter().filter(|e| {
            matches!(
                e,
                Event::Schedule(_) | Event::PreScale(_) | Event::AllOff(_)
            )
        });
        waiting.extend(sent.cloned());
        sort_by_time(waiting);
        let due = waiting.partition_point(|e| e.t_ns() < until_ns);
        waiting.drain(..due).for_each(|event| sink.add(&event));
    }

    /// The digest of all added events.
    pub fn finish(self) -> String {
        let Self { mut sink, waiting } = self;
        waiting.iter().for_each(|event| sink.add(event));
        sink.finish()
    }
}

/// First 16 hex digits of the SHA-256 of any text, for the values of scenes and limit tables.
pub fn short_digest(text: &str) -> String {
    hex(Sha256::new_with_prefix(text))
}

#[derive(Clone, Debug, Default)]
struct Sink {
    hash: Sha256,
    /// The line in the making: the same memory for all.
    line: Vec<u8>,
}

impl Sink {
    /// Adds a line of JSON.
    fn add(&mut self, value: &impl Serialize) {
        self.line.clear();
        // Memory takes every byte, and nothing of a trace has keys that are no text.
        let _ = serde_json::to_writer(&mut self.line, value);
        self.line.push(b'\n');
        self.hash.update(&self.line);
    }

    fn finish(self) -> String {
        hex(self.hash)
    }
}

fn hex(hash: Sha256) -> String {
    use std::fmt::Write;
    let mut text = String::with_capacity(16);
    for byte in hash.finalize().iter().take(8) {
        let _ = write!(text, "{byte:02x}");
    }
    text
}

#[cfg(test)]
#[path = "digest_tests.rs"]
mod tests;
