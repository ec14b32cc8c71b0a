//! The records of a real run, written while it runs: whatever ends the program, what was recorded until
//! then is on its way to the disk, in whole lines.

use std::fs::File;
use std::io::{self, Write};
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, Sender, channel};
use std::thread::JoinHandle;

use palpate_core::bus::{Received, SensorBus};
use palpate_core::wire::can::CanFrame;
use palpate_records::contacts_csv;
use palpate_records::schedule;
use palpate_records::trace::{Event, Header};

use crate::failure::Failure;
use crate::files::write_can_log;
use crate::output::note;

/// What a file of the journal holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// Contacts, CSV.
    Contacts,
    /// The schedule, JSON Lines.
    Schedule,
    /// The CAN side, as candump logs it.
    Can,
}

/// What happened since the last piece.
struct Piece {
    events: Vec<Event>,
    frames: Vec<Received>,
}

/// Files that grow on a thread of their own: a slow disk delays nobody.
pub(super) struct Journal {
    pieces: Option<Sender<Piece>>,
    thread: Option<JoinHandle<Result<(), Failure>>>,
    failed: Arc<AtomicBool>,
    /// How many of the recorder's events have been handed over.
    told: usize,
}

impl Journal {
    /// Creates the files with their first lines. Unless `quiet`, notes are told to people as well.
    ///
    /// # Errors
    /// [`Failure::Write`] for the first that cannot be written.
    pub(super) fn start(
        files: &[(Kind, PathBuf)],
        header: &Header,
        quiet: bool,
    ) -> Result<Self, Failure> {
        let mut open = Vec::new();
        for (kind, path) in files {
            let mut first = Vec::new();
            let begun = match kind {
                Kind::Contacts => writeln!(first, "{}", contacts_csv::HEADER),
                Kind::Schedule => schedule::write_header(header, &mut first),
                Kind::Can => Ok(()),
            };
            let created = begun
                .and_then(|()| File::create(path))
                .and_then(|mut file| {
                    file.write_all(&first)?;
                    Ok(file)
                });
            let file = created.map_err(|error| failure(path, error))?;
            open.push((*kind, path.clone(), file));
        }
        let (pieces, orders) = channel();
        let failed = Arc::new(AtomicBool::new(false));
        let flag = Arc::clone(&failed);
        let thread = std::thread::Builder::new()
            .name("journal".into())
            .spawn(move || {
                let result = keep(&mut open, &orders, quiet);
                flag.store(result.is_err(), Ordering::Relaxed);
                result
            })
            .map_err(|e| Failure::Device(format!("the journal's thread: {e}")))?;
        Ok(Self {
            pieces: Some(pieces),
            thread: Some(thread),
            failed,
            told: 0,
        })
    }

    /// Hands over what is new. All events of one instant have to be there.
    pub(super) fn tell(&mut self, events: &[Event], frames: Vec<Received>) {
        let events = events.get(self.told..).unwrap_or_default().to_vec();
        self.told += events.len();
        if (events.is_empty() && frames.is_empty()) || self.has_failed() {
            return;
        }
        if let Some(pieces) = &self.pieces {
            // A thread that has ended has set the flag.
            let _ = pieces.send(Piece { events, frames });
        }
    }

    /// Whether a file could not be written: a full disk ends the run.
    pub(super) fn has_failed(&self) -> bool {
        self.failed.load(Ordering::Relaxed)
    }

    /// Waits until everything is written.
    ///
    /// # Errors
    /// [`Failure::Write`] with the file and what the system said.
    pub(super) fn finish(mut self) -> Result<(), Failure> {
        self.pieces = None;
        let joined = self.thread.take().map(JoinHandle::join);
        match joined {
            Some(Ok(result)) => result,
            _ => Err(Failure::Device("the journal's thread panicked".into())),
        }
    }
}

fn failure(path: &std::path::Path, error: io::Error) -> Failure {
    Failure::Write {
        path: path.display().to_string(),
        error,
    }
}

/// Writes pieces until there are no more.
fn keep(
    files: &mut [(Kind, PathBuf, File)],
    pieces: &Receiver<Piece>,
    quiet: bool,
) -> Result<(), Failure> {
    let mut text = Vec::new();
    while let Ok(piece) = pieces.recv() {
        for event in piece.events.iter().filter(|_| !quiet) {
            if let Event::Note { t_us, text } = event {
                note(&format!("{:.3} s: {text}", *t_us as f64 * 1e-6));
            }
        }
        for (kind, path, file) in &mut *files {
            text.clear();
            let rendered = match kind {
                Kind::Contacts => contacts_csv::write_rows(&piece.events, &mut text),
                Kind::Schedule => schedule::write_records(&piece.events, &mut text),
                Kind::Can => write_can_log(&piece.frames, &mut text),
            };
            // One write for whole lines: a death in between leaves no half of one.
            let written = rendered.and_then(|()| file.write_all(&text));
            written.map_err(|error| failure(path, error))?;
        }
    }
    Ok(())
}

/// A sensor bus that keeps what crosses it until somebody takes it away.
pub(super) struct Tap<S> {
    pub(super) inner: S,
    pub(super) now: palpate_core::units::Instant,
    kept: Option<Vec<Received>>,
}

impl<S> Tap<S> {
    pub(super) fn new(inner: S, keep: bool) -> Self {
        Self {
            inner,
            now: palpate_core::units::Instant::ZERO,
            kept: keep.then(Vec::new),
        }
    }

    /// What crossed it since the last time.
    pub(super) fn take(&mut self) -> Vec<Received> {
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
    use super::*;
    use crate::files::Setup;
    use crate::run::{Input, run};
    use palpate_records::trace::Trace;

    /// A run of an emulated bench; its pieces could have come from a real one.
    fn trace() -> Trace {
        let setup = Setup::load("sphere-along", "emulated").unwrap();
        run(&setup, &Input::Scene, 1).unwrap().trace
    }

    #[test]
    fn pieces_make_the_same_files_as_a_whole_run() {
        let trace = trace();
        let folder = std::env::temp_dir().join(format!("palpate-journal-{}", std::process::id()));
        std::fs::create_dir_all(&folder).unwrap();
        let files = [
            (Kind::Contacts, folder.join("c.csv")),
            (Kind::Schedule, folder.join("s.jsonl")),
        ];
        let mut journal = Journal::start(&files, &trace.header, true).unwrap();
        for end in 0..=trace.events.len() {
            let whole = |i: usize| trace.events.get(i).map(Event::t_ns);
            if end == trace.events.len() || whole(end) != whole(end.wrapping_sub(1)) {
                journal.tell(&trace.events[..end], vec![]);
            }
        }
        journal.finish().unwrap();
        let (mut contacts, mut plan) = (Vec::new(), Vec::new());
        contacts_csv::write_contacts(&trace, &mut contacts).unwrap();
        schedule::write_schedule(&trace, &mut plan).unwrap();
        assert_eq!(std::fs::read(&files[0].1).unwrap(), contacts);
        assert_eq!(std::fs::read(&files[1].1).unwrap(), plan);
        std::fs::remove_dir_all(&folder).unwrap();
    }

    #[test]
    fn a_full_disk_is_noticed() {
        let header = trace().header;
        let files = [(Kind::Contacts, PathBuf::from("/dev/full"))];
        let refused = Journal::start(&files, &header, true).err().unwrap();
        assert_eq!(refused.status(), 3);
    }
}
