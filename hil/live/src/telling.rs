//! Standard output of a program that serves clients: words for people, or JSON Lines.
//!
//! A thread of its own writes: a reader that stops reading keeps no unit and no emulator from its next turn.

use std::io::{self, Write};
use std::sync::{Arc, Condvar, Mutex, PoisonError};
use std::thread::Builder;
use std::time::Duration;

use palpate_buses::served::wait::monotonic_ns;
use palpate_records::json::write_json;
use palpate_run::Failure;
use serde::Serialize;

use crate::lock::held;

/// Bytes that wait for a reader at the most: a quarter of a minute of a hand whose outputs all change.
const MOST: usize = 16 << 20;
/// Bytes that are written in one go: a pipe takes as many at once.
const PIECE: usize = 4096;
/// Time after which a reader at the end that takes nothing counts as gone.
const PATIENCE: Duration = Duration::from_secs(3);

/// Form of a program's output.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Telling {
    /// Words for people.
    Words,
    /// JSON Lines.
    Json,
    /// No output.
    Nothing,
}

impl Telling {
    /// The form that the options `--json` and `--quiet` ask for.
    pub const fn new(json: bool, quiet: bool) -> Self {
        match (json, quiet) {
            (true, _) => Self::Json,
            (_, true) => Self::Nothing,
            _ => Self::Words,
        }
    }
}

/// An event to tell: an object of JSON, or words.
pub trait Say: Serialize {
    /// Writes words for people; none for an event that does not matter to them.
    ///
    /// # Errors
    /// Errors of the stream.
    fn words(&self, out: &mut dyn Write) -> io::Result<()>;
}

/// Lines that found no place, because nobody read those before.
#[derive(Debug, Serialize)]
#[serde(tag = "event", rename = "lost")]
struct Lost {
    t_ns: u64,
    lines: u64,
}

impl Say for Lost {
    fn words(&self, out: &mut dyn Write) -> io::Result<()> {
        writeln!(
            out,
            "  {} lines are left out: nobody read those before",
            self.lines
        )
    }
}

/// Output that waits for the thread that writes.
#[derive(Debug, Default)]
struct Waiting {
    bytes: Vec<u8>,
    /// `true` once the thread may write the bytes.
    is_due: bool,
    /// `true` while the thread writes the bytes that it took.
    is_writing: bool,
    /// Pieces written so far.
    written: u64,
    /// Lines that found no place since the last one that told so.
    lost: u64,
    /// `true` once nothing is written any more.
    is_over: bool,
    /// Error that ended the writing, until it is reported.
    failed: Option<io::Error>,
}

impl Waiting {
    /// Takes the error that ended the writing. A reader that went away is no error: the program serves on, unheard.
    fn failure(&mut self) -> Result<(), Failure> {
        match self.failed.take() {
            Some(error) if error.kind() != io::ErrorKind::BrokenPipe => {
                Err(Failure::written("standard output")(error))
            }
            _ => Ok(()),
        }
    }
}

#[derive(Debug, Default)]
struct Desk {
    waiting: Mutex<Waiting>,
    changed: Condvar,
}

impl Desk {
    /// Writes waiting output, until that fails or nobody speaks any more.
    fn write(&self, mut out: impl Write) {
        let mut taken = Vec::new();
        loop {
            let idle = |w: &mut Waiting| !w.is_over && (!w.is_due || w.bytes.is_empty());
            let waited = self.changed.wait_while(held(&self.waiting), idle);
            let mut waiting = waited.unwrap_or_else(PoisonError::into_inner);
            if waiting.is_over {
                return;
            }
            std::mem::swap(&mut waiting.bytes, &mut taken);
            (waiting.is_due, waiting.is_writing) = (false, true);
            drop(waiting);
            let written = taken.chunks(PIECE).try_for_each(|piece| -> io::Result<()> {
                out.write_all(piece)?;
                held(&self.waiting).written += 1;
                Ok(())
            });
            let written = written.and_then(|()| out.flush());
            taken.clear();
            let mut waiting = held(&self.waiting);
            waiting.is_writing = false;
            waiting.is_over |= written.is_err();
            waiting.failed = written.err();
            self.changed.notify_all();
        }
    }

    /// Returns when everything is written, or nobody has taken anything for a while.
    fn drain(&self) -> Result<(), Failure> {
        let mut waiting = held(&self.waiting);
        waiting.is_due = true;
        self.changed.notify_all();
        while !waiting.is_over && (waiting.is_writing || !waiting.bytes.is_empty()) {
            let written = waiting.written;
            let waited = self.changed.wait_timeout(waiting, PATIENCE);
            let (now, late) = waited.unwrap_or_else(PoisonError::into_inner);
            waiting = now;
            if late.timed_out() && waiting.written == written {
                let unread = format!("nobody has read it for {} s", PATIENCE.as_secs());
                waiting.failed = Some(io::Error::new(io::ErrorKind::TimedOut, unread));
                waiting.is_over = true;
            }
        }
        waiting.failure()
    }
}

/// Standard output, in the form that the command line chose.
#[derive(Debug)]
pub struct Teller {
    form: Telling,
    desk: Arc<Desk>,
    /// The line in the making: the same memory for all.
    line: Vec<u8>,
}

impl Teller {
    /// Speaks in this form.
    ///
    /// # Errors
    /// [`Failure::Device`] where the system gives no thread.
    pub fn new(form: Telling) -> Result<Self, Failure> {
        Self::to(form, io::stdout())
    }

    fn to(form: Telling, out: impl Write + Send + 'static) -> Result<Self, Failure> {
        let desk = Arc::new(Desk::default());
        let own = Arc::clone(&desk);
        let thread = Builder::new().name("words".into());
        let thread = thread.spawn(move || own.write(out));
        thread.map_err(|e| Failure::Device(format!("a thread that writes: {e}")))?;
        Ok(Self {
            form,
            desk,
            line: Vec::new(),
        })
    }

    /// Tells an event, without waiting for a reader.
    ///
    /// # Errors
    /// [`Failure::Write`] for a full disk; a reader that went away is no error.
    pub fn tell(&mut self, told: &impl Say) -> Result<(), Failure> {
        self.say(told, MOST)
    }

    /// Lets readers have all lines so far.
    ///
    /// # Errors
    /// Errors of [`Self::tell`].
    pub fn flush(&mut self) -> Result<(), Failure> {
        let mut waiting = held(&self.desk.waiting);
        waiting.is_due = true;
        self.desk.changed.notify_all();
        waiting.failure()
    }

    /// Says the last word, and returns when everything is written.
    ///
    /// # Errors
    /// As [`Self::tell`], and [`Failure::Write`] where nobody reads it.
    pub fn finish(mut self, last: &impl Say) -> Result<(), Failure> {
        self.say(last, usize::MAX)?;
        self.desk.drain()
    }

    /// Queues a line, if fewer than `most` bytes wait.
    fn say(&mut self, told: &impl Say, most: usize) -> Result<(), Failure> {
        let mut waiting = held(&self.desk.waiting);
        waiting.failure()?;
        if self.form == Telling::Nothing || waiting.is_over {
            return Ok(());
        }
        if waiting.bytes.len() >= most {
            waiting.lost += 1;
            return Ok(());
        }
        self.line.clear();
        let lost = Lost {
            t_ns: monotonic_ns(),
            lines: std::mem::take(&mut waiting.lost),
        };
        let first = match lost.lines {
            0 => Ok(()),
            _ => append(self.form, &lost, &mut self.line),
        };
        let put = first.and_then(|()| append(self.form, told, &mut self.line));
        waiting.bytes.extend_from_slice(&self.line);
        put.map_err(Failure::written("standard output"))
    }
}

impl Drop for Teller {
    /// Lets readers have the last lines of a program that ends otherwise.
    fn drop(&mut self) {
        // An error here reaches nobody.
        let _ = self.desk.drain();
        held(&self.desk.waiting).is_over = true;
        self.desk.changed.notify_all();
    }
}

/// Appends an event to a line, in this form.
fn append(form: Telling, told: &impl Say, line: &mut Vec<u8>) -> io::Result<()> {
    match form {
        Telling::Json => {
            write_json(told, &mut *line)?;
            line.push(b'\n');
            Ok(())
        }
        _ => told.words(line),
    }
}

#[cfg(test)]
#[path = "telling_tests.rs"]
mod tests;
