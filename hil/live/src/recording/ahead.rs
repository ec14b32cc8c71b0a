//! Rows of a recording, read by a thread while those before them are worked on.

use std::sync::mpsc::{Receiver, Sender, SyncSender, channel, sync_channel};
use std::thread;

use palpate_files::{FileError, Input, Rows};
use palpate_run::Failure;

/// Rows that are handed over together.
const ROWS: usize = 256;
/// Batches that are read ahead, at most.
const AHEAD: usize = 4;

/// Rows that were read together.
#[derive(Default)]
struct Batch {
    times_us: Vec<u64>,
    counts: Vec<u16>,
}

/// Work on a row: its time in microseconds, and its counts.
pub type Each<'a> = dyn FnMut(u64, &[u16]) -> Result<(), Failure> + 'a;

/// Hands every row to `each`, in the order of the file; returns the table, read to its end.
///
/// # Errors
/// The first error of the file or of `each`, whichever comes first in the file.
pub fn ahead(rows: Rows<Input>, each: &mut Each<'_>) -> Result<Rows<Input>, Failure> {
    let (full, coming) = sync_channel(AHEAD);
    let (back, empty) = channel();
    thread::scope(|scope| {
        let reader = scope.spawn(move || read(rows, &full, &empty));
        let done = work(coming, &back, each);
        let rows = match reader.join() {
            Ok(rows) => rows,
            Err(panic) => std::panic::resume_unwind(panic),
        };
        done?;
        Ok(rows?)
    })
}

/// Reads until the table ends or no one takes its rows any more.
fn read(
    mut rows: Rows<Input>,
    full: &SyncSender<Batch>,
    empty: &Receiver<Batch>,
) -> Result<Rows<Input>, FileError> {
    let mut row: Vec<u16> = Vec::new();
    loop {
        let mut batch = empty.try_recv().unwrap_or_default();
        batch.times_us.clear();
        batch.counts.clear();
        let mut end = None;
        while end.is_none() && batch.times_us.len() < ROWS {
            match rows.advance(&mut row) {
                Ok(Some(at)) => {
                    batch.times_us.push(at.time_us);
                    batch.counts.extend_from_slice(&row);
                }
                Ok(None) => end = Some(Ok(())),
                Err(error) => end = Some(Err(error)),
            }
        }
        let is_taken = full.send(batch).is_ok();
        match end {
            Some(Err(error)) => return Err(error),
            Some(Ok(())) => return Ok(rows),
            None if !is_taken => return Ok(rows),
            None => {}
        }
    }
}

/// Works on rows as they come. The receiver goes with the first error, so that the reader does not wait.
fn work(coming: Receiver<Batch>, back: &Sender<Batch>, each: &mut Each<'_>) -> Result<(), Failure> {
    for batch in coming {
        let width = batch.counts.len() / batch.times_us.len().max(1);
        for (us, counts) in batch.times_us.iter().zip(batch.counts.chunks(width.max(1))) {
            each(*us, counts)?;
        }
        // The reader may have ended.
        let _ = back.send(batch);
    }
    Ok(())
}

#[cfg(test)]
#[path = "ahead_tests.rs"]
mod tests;
