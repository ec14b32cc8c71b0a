//! Records that are written while they come in: whatever ends the program, what was recorded until then is on
//! its way to the disk. A thread of its own does it, behind a queue of fixed length: a slow disk delays nobody
//! and costs frames, which are counted.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, SyncSender, TrySendError, sync_channel};
use std::thread::JoinHandle;

use palpate_core::bus::{Received, SensorBus};
use palpate_core::units::Instant;
use palpate_core::wire::can::CanFrame;
use palpate_records::trace::Event;

use super::sink::Sink;
use crate::failure::Failure;
use crate::output::note;

/// Pieces that wait for the disk, one a turn of the loop.
const QUEUE: usize = 1 << 10;
/// Frames that wait for room in the queue, 24 bytes each: almost three seconds of a full hand.
const WAITING: usize = 1 << 16;

/// What happened since the last piece.
#[derive(Debug, Default)]
pub struct Piece {
    /// In the order of time, all of an instant together.
    pub events: Vec<Event>,
    /// Frames on the sensor buses.
    pub frames: Vec<Received>,
}

/// Files that grow on a thread of their own.
#[derive(Debug)]
pub struct Journal {
    pieces: Option<SyncSender<Piece>>,
    thread: Option<JoinHandle<Result<(), Failure>>>,
    failed: Arc<AtomicBool>,
    /// How many of the recorder's events have been handed over.
    told: usize,
    /// What found no room in the queue.
    waiting: Piece,
    dropped: u64,
}

impl Journal {
    /// Takes files that have their first lines. If it `tells`, notes go to people as well.
    ///
    /// # Errors
    /// [`Failure::Device`] when the system gives no thread.
    pub fn start(mut files: Vec<Sink>, tells: bool) -> Result<Self, Failure> {
        let (pieces, orders) = sync_channel(QUEUE);
        let failed = Arc::new(AtomicBool::new(false));
        let flag = Arc::clone(&failed);
        let thread = std::thread::Builder::new()
            .name("journal".into())
            .spawn(move || {
                let result = keep(&mut files, &orders, tells);
                let result = result.and_then(|()| files.into_iter().try_for_each(Sink::finish));
                flag.store(result.is_err(), Ordering::Relaxed);
                result
            })
            .map_err(|e| Failure::Device(format!("the journal's thread: {e}")))?;
        Ok(Self {
            pieces: Some(pieces),
            thread: Some(thread),
            failed,
            told: 0,
            waiting: Piece::default(),
            dropped: 0,
        })
    }

    /// Hands over what is new, without waiting. All events of one instant have to be there.
    pub fn tell(&mut self, events: &[Event], mut frames: Vec<Received>) {
        let events = events.get(self.told..).unwrap_or_default();
        self.told += events.len();
        if self.has_failed() {
            return;
        }
        self.waiting.events.extend_from_slice(events);
        let room = WAITING.saturating_sub(self.waiting.frames.len());
        self.dropped += frames.len().saturating_sub(room) as u64;
        frames.truncate(room);
        self.waiting.frames.append(&mut frames);
        if self.waiting.events.is_empty() && self.waiting.frames.is_empty() {
            return;
        }
        if let Some(pieces) = &self.pieces {
            match pieces.try_send(std::mem::take(&mut self.waiting)) {
                Err(TrySendError::Full(piece)) => self.waiting = piece,
                // A thread that has ended has set the flag.
                Ok(()) | Err(TrySendError::Disconnected(_)) => {}
            }
        }
    }

    /// Whether a file could not be written: a full disk ends the run.
    pub fn has_failed(&self) -> bool {
        self.failed.load(Ordering::Relaxed)
    }

    /// Frames for which there was no room: the disk was too slow. Events are never left out.
    pub const fn dropped(&self) -> u64 {
        self.dropped
    }

    /// Waits until everything is written.
    ///
    /// # Errors
    /// [`Failure::Write`] with the file and what the system said.
    pub fn finish(mut self) -> Result<(), Failure> {
        if let Some(pieces) = self.pieces.take() {
            // A thread that has ended tells why below.
            let _ = pieces.send(std::mem::take(&mut self.waiting));
        }
        let joined = self.thread.take().map(JoinHandle::join);
        match joined {
            Some(Ok(result)) => result,
            _ => Err(Failure::Device("the journal's thread panicked".into())),
        }
    }
}

/// Writes pieces until there are no more.
fn keep(files: &mut [Sink], pieces: &Receiver<Piece>, tells: bool) -> Result<(), Failure> {
    while let Ok(piece) = pieces.recv() {
        for event in piece.events.iter().filter(|_| tells) {
            if let Event::Note { t_us, text } = event {
                note(&format!("{:.3} s: {text}", *t_us as f64 * 1e-6));
            }
        }
        files.iter_mut().try_for_each(|file| file.piece(&piece))?;
    }
    Ok(())
}

/// A sensor bus that keeps what crosses it, in either direction, until somebody takes it away: as the host saw
/// it, so that what a fault layer swallowed is not there, and what it garbled is garbled.
#[derive(Debug)]
pub struct Tap<S> {
    /// The bus.
    pub inner: S,
    /// The time that what is sent gets.
    pub now: Instant,
    kept: Option<Vec<Received>>,
}

impl<S> Tap<S> {
    /// A tap on a bus; one that does not `keep` costs nothing.
    pub fn new(inner: S, keep: bool) -> Self {
        Self {
            inner,
            now: Instant::ZERO,
            kept: keep.then(Vec::new),
        }
    }

    /// What crossed it since the last time.
    pub fn take(&mut self) -> Vec<Received> {
        self.kept.as_mut().map(std::mem::take).unwrap_or_default()
    }
}

impl<S: SensorBus> SensorBus for Tap<S> {
    type Error = S::Error;

    fn receive(&mut self) -> Result<Option<Received>, S::Error> {
        let received = self.inner.receive()?;
        if let Some(kept) = &mut self.kept {
            kept.extend(received);
        }
        Ok(received)
    }

    fn transmit(&mut self, bus: u8, frame: &CanFrame) -> Result<(), S::Error> {
        self.inner.transmit(bus, frame)?;
        if let Some(kept) = &mut self.kept {
            let (at, frame) = (self.now, *frame);
            kept.push(Received { at, bus, frame });
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use std::path::PathBuf;

    use palpate_records::mcap::{self, Traffic, write_mcap};
    use palpate_records::trace::Trace;
    use palpate_records::{contacts_csv, schedule, vcd};

    use super::*;
    use crate::record::sink::{About, Kind};
    use crate::run::{Input, Keep, run_keeping};
    use palpate_files::Setup;

    /// A run of an emulated bench; its pieces could have come from a real one.
    fn run() -> (Trace, Vec<Received>) {
        let setup = Setup::load("sphere-along", "emulated").unwrap();
        let keep = Keep {
            can: true,
            ..Keep::default()
        };
        let outcome = run_keeping(&setup, &Input::Scene, 1, keep).unwrap();
        (outcome.trace, outcome.can)
    }

    #[test]
    fn pieces_make_the_same_files_as_a_whole_run() {
        let (trace, frames) = run();
        let folder = std::env::temp_dir().join(format!("palpate-journal-{}", std::process::id()));
        std::fs::create_dir_all(&folder).unwrap();
        let path = |name: &str| folder.join(name);
        let files = [
            (Kind::Contacts, path("c.csv")),
            (Kind::Schedule, path("s.jsonl")),
            (Kind::Vcd, path("v.vcd")),
            (Kind::Mcap, path("m.mcap")),
        ];
        let about = About::Run(&trace.header, &[]);
        let mut journal = Journal::start(Sink::create_all(&files, &about).unwrap(), false).unwrap();
        let mut sent = 0;
        for end in 0..=trace.events.len() {
            let at = |i: usize| trace.events.get(i).map(Event::t_ns);
            if end == trace.events.len() || at(end) != at(end.wrapping_sub(1)) {
                let until = at(end).unwrap_or(u64::MAX);
                let due = frames[sent..].iter();
                let due = due.take_while(|f| f.at.as_micros() * 1000 < until);
                let due: Vec<_> = due.copied().collect();
                sent += due.len();
                journal.tell(&trace.events[..end], due);
                // The thread may be slower than this loop; nothing here is to be dropped.
                while !journal.waiting.events.is_empty() {
                    std::thread::yield_now();
                    journal.tell(&trace.events[..end], vec![]);
                }
            }
        }
        journal.finish().unwrap();
        let (mut contacts, mut plan) = (Vec::new(), Vec::new());
        contacts_csv::write_contacts(&trace, &mut contacts).unwrap();
        schedule::write_schedule(&trace, &mut plan).unwrap();
        assert_eq!(std::fs::read(path("c.csv")).unwrap(), contacts);
        assert_eq!(std::fs::read(path("s.jsonl")).unwrap(), plan);
        let mut dump = Vec::new();
        vcd::write_vcd(&trace, &mut dump).unwrap();
        let written = std::fs::read(path("v.vcd")).unwrap();
        // A growing dump ends with its last event, a whole one with the run.
        assert!(dump.starts_with(&written) || written.starts_with(&dump));
        let grown = mcap::read(&std::fs::read(path("m.mcap")).unwrap()).unwrap();
        let mut whole = Vec::new();
        let traffic = Traffic {
            can: &frames,
            i2c: &[],
        };
        write_mcap(&trace, traffic, &[], &mut whole).unwrap();
        let whole = mcap::read(&whole).unwrap();
        assert_eq!(
            (grown.frames, grown.messages),
            (whole.frames, whole.messages)
        );
        std::fs::remove_dir_all(&folder).unwrap();
    }

    #[test]
    fn a_full_disk_is_noticed() {
        let header = run().0.header;
        for kind in [Kind::Contacts, Kind::Mcap, Kind::Vcd] {
            let files = [(kind, PathBuf::from("/dev/full"))];
            let refused = Sink::create_all(&files, &About::Run(&header, &[]));
            assert_eq!(refused.err().unwrap().status(), 3, "{kind:?}");
        }
    }

    #[test]
    fn a_disk_that_does_not_follow_costs_frames_and_no_time() {
        let (pieces, stuck) = sync_channel(2);
        let mut journal = Journal {
            pieces: Some(pieces),
            thread: None,
            failed: Arc::default(),
            told: 0,
            waiting: Piece::default(),
            dropped: 0,
        };
        let frame = Received {
            at: Instant::ZERO,
            bus: 0,
            frame: CanFrame::new(1, &[]).unwrap(),
        };
        let note = Event::Note {
            t_us: 0,
            text: "kept".into(),
        };
        let events = vec![note; 100];
        for turn in 0..100 {
            journal.tell(&events[..=turn], vec![frame; 1000]);
        }
        let held = 2 * 1000 + WAITING as u64;
        assert_eq!(journal.dropped(), 100_000 - held);
        let mut kept: usize = stuck.try_iter().map(|p| p.events.len()).sum();
        kept += journal.waiting.events.len();
        assert_eq!(kept, 100, "events are never left out");
    }
}
