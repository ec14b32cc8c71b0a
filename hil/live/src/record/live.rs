//! Recording of sensor buses without a run: everything that crosses them, until a signal or the time ends it.

use std::path::PathBuf;

use palpate_buses::can::CanBuses;
use palpate_buses::pacer::RunClock;
use palpate_core::bus::{CanBus, Received};
use palpate_core::units::{Duration, Instant};
use palpate_files::Format;
use serde::Serialize;

use super::{About, Journal, Sink};
use crate::clock;
use crate::interfaces::reports;
use crate::output::Outputs;
use crate::progress::Progress;
use palpate_buses::signals::Signals;
use palpate_run::CanReport;
use palpate_run::Failure;

/// Time between two looks at the buses' queue.
const TURN: Duration = Duration::from_millis(2);

/// Counts of a recording.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Recorded {
    /// Always real: this program cannot know the senders on a virtual interface.
    pub source: &'static str,
    /// Frames recorded.
    pub frames: u64,
    /// Frames that the recording lacks because the disk did not follow.
    pub frames_not_recorded: u64,
    /// The interfaces, bus by bus.
    pub can: Vec<CanReport>,
    /// Length, milliseconds.
    pub length_ms: u64,
    /// Interfaces that went down or came back, and when.
    pub notes: Vec<String>,
}

/// Records interfaces until `length` is over, a signal comes or a file cannot be written.
///
/// # Errors
/// [`Failure::Device`] for an interface that is not there, [`Failure::Write`] for a full disk.
pub fn record(
    interfaces: &[String],
    files: &[(Format, PathBuf)],
    length: Option<Duration>,
    outputs: Outputs<'_>,
) -> Result<Recorded, Failure> {
    let signals = Signals::catch().map_err(|e| Failure::Device(format!("signals: {e}")))?;
    let all = interfaces.iter().map(|name| (name.clone(), Vec::new()));
    let (clock, epoch_us) = (RunClock::start(), clock::unix_us());
    let can = CanBuses::open(&all.collect::<Vec<_>>(), clock)
        .map_err(|e| Failure::Device(e.to_string()))?;
    let sinks = Sink::create_all(files, &About::Buses(interfaces), outputs)?;
    let journal = Journal::start(sinks, false)?;
    let progress = match length {
        Some(_) => Progress::of_part("record"),
        None => Progress::endless("record"),
    };
    let stop = |now: Instant| {
        if let Some(length) = length {
            progress.part(now.as_micros() as f64 / length.as_micros() as f64);
        }
        signals.caught().is_some() || length.is_some_and(|l| now >= Instant::ZERO + l)
    };
    listen(can, journal, interfaces, (clock, epoch_us), stop)
}

/// Records from buses that are open.
pub(super) fn listen(
    mut can: CanBuses,
    mut journal: Journal,
    interfaces: &[String],
    (clock, epoch_us): (RunClock, u64),
    stop: impl Fn(Instant) -> bool,
) -> Result<Recorded, Failure> {
    let (mut frames, mut notes) = (0, Vec::new());
    loop {
        let now = clock.now();
        let last = stop(now) || journal.has_failed();
        let mut fresh = Vec::new();
        while let Some(received) = can
            .receive()
            .map_err(|e| Failure::Device(format!("sensor bus: {e}")))?
        {
            let at = received.at.as_micros().saturating_add(epoch_us);
            fresh.push(Received {
                at: Instant::from_micros(at),
                ..received
            });
        }
        frames += fresh.len() as u64;
        journal.add(&[], fresh, Vec::new());
        while let Some(note) = can.note() {
            notes.push(format!(
                "{:.3} s: {}",
                note.at.as_micros() as f64 * 1e-6,
                note.text
            ));
        }
        if last {
            break;
        }
        clock.sleep_until(now + TURN);
    }
    let frames_not_recorded = journal.dropped();
    let length_ms = clock.now().as_micros() / 1000;
    let tallies = can.tallies();
    journal.finish()?;
    Ok(Recorded {
        source: "real",
        frames: frames - frames_not_recorded,
        frames_not_recorded,
        can: reports(interfaces, &tallies),
        length_ms,
        notes,
    })
}

#[cfg(test)]
#[path = "live_tests.rs"]
mod tests;
