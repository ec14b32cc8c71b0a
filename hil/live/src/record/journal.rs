//! Records that are written while they come in: whatever ends the program, everything recorded until then is on its way
//! to the disk. A thread of its own writes, behind a queue of fixed length: a slow disk delays no loop and costs
//! frames, which are counted.

use std::io;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError, SyncSender, TrySendError, sync_channel};
use std::thread::JoinHandle;
use std::time::Duration;

use palpate_core::bus::Received;
use palpate_records::readings::TaxelFrame;
use palpate_records::trace::{Event, event};

use super::sink::Sink;
use crate::output::note;
use palpate_run::{Failure, Piece};

/// Pieces that wait for the disk, one a turn of the loop.
const QUEUE: usize = 1 << 10;
/// Frames that wait for room in the queue, 24 bytes each: almost three seconds of a full hand.
const WAITING: usize = 1 << 16;
/// Scans that wait for room, of all taxels, 2 kB each of a full hand: five seconds of it.
const SCANS_WAITING: usize = 1 << 9;
/// Time after which a reader at the end that takes nothing counts as gone.
const PATIENCE: Duration = Duration::from_secs(5);

/// Files that grow on a thread of their own.
#[derive(Debug)]
pub struct Journal {
    pieces: Option<SyncSender<Piece>>,
    thread: Option<JoinHandle<Result<(), Failure>>>,
    /// A message for each written piece; closed once the thread has ended.
    written: Receiver<()>,
    /// Path of a file that needs a reader.
    stream: Option<PathBuf>,
    failed: Arc<AtomicBool>,
    /// Events and frames that found no room in the queue.
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
        // A caller who does not wait for the message needs none.
        let (writes, written) = sync_channel(1);
        let stream = files.iter().find_map(Sink::stream).map(Path::to_owned);
        let failed = Arc::new(AtomicBool::new(false));
        let flag = Arc::clone(&failed);
        let thread = std::thread::Builder::new()
            .name("journal".into())
            .spawn(move || {
                let result = keep(&mut files, &orders, &writes, tells);
                let result = result.and_then(|()| files.into_iter().try_for_each(Sink::finish));
                flag.store(result.is_err(), Ordering::Relaxed);
                result
            })
            .map_err(|e| Failure::Device(format!("the journal's thread: {e}")))?;
        Ok(Self {
            pieces: Some(pieces),
            thread: Some(thread),
            written,
            stream,
            failed,
            waiting: Piece::default(),
            dropped: 0,
        })
    }

    /// Hands over new data, without waiting. All events of one instant have to be there.
    pub fn add(
        &mut self,
        events: &[Event],
        mut frames: Vec<Received>,
        mut taxels: Vec<TaxelFrame>,
    ) {
        if self.has_failed() {
            return;
        }
        self.waiting.events.extend_from_slice(events);
        self.dropped += fill(&mut self.waiting.can, &mut frames, WAITING);
        self.dropped += fill(&mut self.waiting.taxels, &mut taxels, SCANS_WAITING);
        if self.waiting.events.is_empty() && self.waiting.can.is_empty() {
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

    /// Tells whether a file could not be written: a full disk ends the run.
    pub fn has_failed(&self) -> bool {
        self.failed.load(Ordering::Relaxed)
    }

    /// Frames and scans for which there was no room: the disk was too slow. Events are never left out.
    pub const fn dropped(&self) -> u64 {
        self.dropped
    }

    /// Waits until everything is written. A pipe that nobody reads is waited for no longer than five seconds.
    ///
    /// # Errors
    /// [`Failure::Write`] with the file and the system's error.
    pub fn finish(mut self) -> Result<(), Failure> {
        let mut last = self
            .pieces
            .take()
            .map(|pieces| (pieces, std::mem::take(&mut self.waiting)));
        loop {
            if let Some((pieces, piece)) = last.take() {
                last = match pieces.try_send(piece) {
                    Err(TrySendError::Full(piece)) => Some((pieces, piece)),
                    // A thread that has ended tells why below.
                    Ok(()) | Err(TrySendError::Disconnected(_)) => None,
                };
            }
            match (self.written.recv_timeout(PATIENCE), &self.stream) {
                (Err(RecvTimeoutError::Disconnected), _) => break,
                (Err(RecvTimeoutError::Timeout), Some(path)) => {
                    let unread = format!("nobody has read it for {} s", PATIENCE.as_secs());
                    let unread = io::Error::new(io::ErrorKind::TimedOut, unread);
                    return Err(Failure::written(path)(unread));
                }
                // A disk takes its time.
                _ => {}
            }
        }
        let joined = self.thread.take().map(JoinHandle::join);
        match joined {
            Some(Ok(result)) => result,
            _ => Err(Failure::Device("the journal's thread panicked".into())),
        }
    }
}

/// Appends as much as there is room for. Returns the number left over.
fn fill<T>(waiting: &mut Vec<T>, new: &mut Vec<T>, most: usize) -> u64 {
    let room = most.saturating_sub(waiting.len());
    let over = new.len().saturating_sub(room);
    new.truncate(room);
    waiting.append(new);
    over as u64
}

/// Writes pieces until there are no more.
fn keep(
    files: &mut [Sink],
    pieces: &Receiver<Piece>,
    writes: &SyncSender<()>,
    tells: bool,
) -> Result<(), Failure> {
    while let Ok(piece) = pieces.recv() {
        for told in event::each::<event::Note>(&piece.events).filter(|_| tells) {
            note(&format!("{:.3} s: {}", told.t_us as f64 * 1e-6, told.text));
        }
        files.iter_mut().try_for_each(|file| file.piece(&piece))?;
        let _ = writes.try_send(());
    }
    Ok(())
}

#[cfg(test)]
#[path = "journal_tests.rs"]
mod tests;
