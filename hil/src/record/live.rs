//! Sensor buses to a recording, without a run: everything that crosses them, until somebody says stop.

use std::path::PathBuf;

use palpate_buses::can::CanBuses;
use palpate_buses::pacer::RunClock;
use palpate_core::bus::{Received, SensorBus};
use palpate_core::units::{Duration, Instant};
use serde::Serialize;

use super::{About, Journal, Kind, Sink};
use crate::clock;
use crate::failure::Failure;
use crate::run::real::{CanReport, Signals};

/// How often the buses' queue is emptied.
const TURN: Duration = Duration::from_millis(2);

/// What a recording came to.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Recorded {
    /// Always real: whoever sends on a virtual interface, this program does not know.
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
    files: &[(Kind, PathBuf)],
    length: Option<Duration>,
) -> Result<Recorded, Failure> {
    let signals = Signals::catch().map_err(|e| Failure::Device(format!("signals: {e}")))?;
    let all = interfaces.iter().map(|name| (name.clone(), Vec::new()));
    let (clock, epoch_us) = (RunClock::start(), clock::unix_us());
    let can = CanBuses::open(&all.collect::<Vec<_>>(), clock)
        .map_err(|e| Failure::Device(e.to_string()))?;
    let journal = Journal::start(Sink::create_all(files, &About::Buses(interfaces))?, false)?;
    let stop = |now: Instant| {
        signals.caught().is_some() || length.is_some_and(|l| now >= Instant::ZERO + l)
    };
    listen(can, journal, interfaces, (clock, epoch_us), stop)
}

/// The recording itself, on buses that are open.
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
        journal.tell(&[], fresh);
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
    let reports = interfaces.iter().zip(&tallies);
    Ok(Recorded {
        source: "real",
        frames: frames - frames_not_recorded,
        frames_not_recorded,
        can: reports
            .map(|(name, tally)| CanReport::new(name, tally))
            .collect(),
        length_ms,
        notes,
    })
}

#[cfg(test)]
mod tests {
    use std::os::fd::OwnedFd;
    use std::os::unix::net::UnixDatagram;

    use palpate_buses::can::Endpoint;

    use super::*;
    use crate::recording::read_can_recording;

    /// What comes over a bus is in the files, with times of the wall clock, and can be read again.
    #[test]
    fn a_bus_is_recorded_in_both_formats() {
        let (ours, theirs) = UnixDatagram::pair().unwrap();
        ours.set_nonblocking(true).unwrap();
        let endpoint = Endpoint::from(OwnedFd::from(ours));
        let clock = RunClock::start();
        let can = CanBuses::over(vec![("test0".into(), vec![], endpoint)], clock).unwrap();
        let folder = std::env::temp_dir().join(format!("palpate-live-{}", std::process::id()));
        std::fs::create_dir_all(&folder).unwrap();
        let files = [
            (Kind::Can, folder.join("a.log")),
            (Kind::Mcap, folder.join("a.mcap")),
        ];
        let names = ["test0".to_owned()];
        let sinks = Sink::create_all(&files, &About::Buses(&names)).unwrap();
        let journal = Journal::start(sinks, false).unwrap();
        for n in 0..100_u8 {
            let mut raw = [0; 16];
            raw[..4].copy_from_slice(&4_u32.to_ne_bytes());
            raw[4] = 8;
            raw[8] = n;
            theirs.send(&raw).unwrap();
        }
        let epoch_us = 1_700_000_000_000_000;
        let stop = |now: Instant| now >= Instant::from_micros(300_000);
        let recorded = listen(can, journal, &names, (clock, epoch_us), stop).unwrap();
        assert_eq!((recorded.frames, recorded.frames_not_recorded), (100, 0));
        let text = std::fs::read_to_string(&files[0].1).unwrap();
        assert!(
            text.starts_with("(1700000000.") && text.contains(" test0 004#"),
            "{text}"
        );
        let log = read_can_recording(&files[0].1, 1).unwrap();
        let mcap = read_can_recording(&files[1].1, 1).unwrap();
        assert_eq!(log, mcap);
        assert_eq!((log.frames.len(), &log.interfaces[0][..]), (100, "test0"));
        for (n, received) in log.frames.iter().enumerate() {
            assert_eq!(usize::from(received.frame.data()[0]), n);
        }
        std::fs::remove_dir_all(&folder).unwrap();
    }
}
