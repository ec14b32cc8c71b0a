//! Writers of a guardian: stops into their records, words to people. Each is a thread of its own from the start, since
//! a disk may hang, and so may a terminal that was stopped or a pipe that is not read.

use std::fmt;
use std::io;
use std::os::fd::BorrowedFd;
use std::sync::Arc;
use std::thread::Builder;
use std::time::Duration;

use arrayvec::{ArrayString, ArrayVec};
use nix::errno::Errno;
use nix::unistd::write;

use super::decide::Text;
use super::latch::Armed;
use crate::desk::Desk;
use crate::pacer::RunClock;
use crate::sys;

/// Stack of a thread that writes a few lines, bytes.
const STACK: usize = 128 * 1024;
/// Bytes of the stack that are touched beforehand.
const TOUCHED: usize = 16 * 1024;
/// Lines that may wait for a terminal.
const LINES: usize = 16;
/// Time between two tries of a disk that refuses.
const RETRY: palpate_core::units::Duration = palpate_core::units::Duration::from_millis(50);
/// Tries of a disk that refuses.
const TRIES: u32 = 100;

/// A line for people.
type Line = ArrayString<1024>;

/// Words to people, on standard error.
#[derive(Clone, Debug)]
pub(super) struct Teller(Arc<Desk<Words>>);

#[derive(Debug, Default)]
struct Words {
    lines: ArrayVec<Line, LINES>,
    /// `true` while a line is being written.
    busy: bool,
}

impl Teller {
    /// Starts the thread.
    ///
    /// # Errors
    /// Error of the system where it gives no thread.
    pub(super) fn start() -> io::Result<Self> {
        let desk = Arc::new(Desk::<Words>::default());
        let own = Arc::clone(&desk);
        let thread = Builder::new().name("words".into()).stack_size(STACK);
        thread.spawn(move || {
            sys::touch_stack::<TOUCHED>();
            loop {
                let mut words = own.wait(|words| words.lines.is_empty());
                let line = words.lines.remove(0);
                words.busy = true;
                drop(words);
                put(line.as_bytes());
                own.leave(|words| words.busy = false);
            }
        })?;
        Ok(Self(desk))
    }

    /// Leaves a line. One that finds no place is lost: the stop's record has its cause.
    pub(super) fn tell(&self, words: fmt::Arguments<'_>) {
        let mut line = Line::new();
        // A line that is too long is cut.
        let _ = fmt::write(&mut line, format_args!("guardian: {words}"));
        if line.is_full() {
            line.pop();
        }
        let _ = line.try_push('\n');
        self.0.leave(|words| {
            let _ = words.lines.try_push(line);
        });
    }

    /// Waits until everything is written, but no longer than this: a terminal that was stopped may stay so.
    pub(super) fn finish(&self, patience: Duration) {
        let unwritten = |words: &mut Words| words.busy || !words.lines.is_empty();
        drop(self.0.wait_for(patience, unwritten));
    }
}

/// Writes to standard error, past the lock that another thread may hold.
#[allow(unsafe_code)]
fn put(mut bytes: &[u8]) {
    // SAFETY: standard error stays open as long as the program runs; a number that is none gives an error.
    let stderr = unsafe { BorrowedFd::borrow_raw(2) };
    while !bytes.is_empty() {
        match write(stderr, bytes) {
            Ok(0) => return,
            Ok(length) => bytes = bytes.get(length..).unwrap_or_default(),
            Err(Errno::EINTR) => {}
            // Nobody reads it.
            Err(_) => return,
        }
    }
}

/// Stops into the records of all adapters.
#[derive(Debug)]
pub(super) struct Latcher(Arc<Desk<Stops>>);

#[derive(Debug, Default)]
struct Stops {
    /// Records that the thread has not taken yet.
    records: Vec<Armed>,
    /// The cause, and whether everything is known to be off.
    stop: Option<(Text, bool)>,
    /// `true` to clear the records.
    disarm: bool,
    busy: bool,
}

impl Latcher {
    /// Starts the thread.
    ///
    /// # Errors
    /// Error of the system where it gives no thread.
    pub(super) fn start(teller: Teller) -> io::Result<Self> {
        let desk = Arc::new(Desk::<Stops>::default());
        let own = Arc::clone(&desk);
        let thread = Builder::new().name("latch".into()).stack_size(STACK);
        thread.spawn(move || {
            sys::touch_stack::<TOUCHED>();
            let mut records = Vec::new();
            loop {
                let mut stops = own.wait(|stops| stops.stop.is_none() && !stops.disarm);
                if !stops.records.is_empty() {
                    records = std::mem::take(&mut stops.records);
                }
                let (stop, disarm) = (stops.stop.take(), std::mem::take(&mut stops.disarm));
                stops.busy = true;
                drop(stops);
                if let Some((cause, verified)) = stop {
                    latch(&mut records, &cause, verified, &teller);
                }
                if disarm {
                    records.iter().for_each(Armed::disarm);
                }
                own.leave(|stops| stops.busy = false);
            }
        })?;
        Ok(Self(desk))
    }

    /// Hands over the records that were armed.
    pub(super) fn hold(&self, records: Vec<Armed>) {
        self.0.leave(|stops| stops.records = records);
    }

    /// Leaves a stop. The first cause counts, also where the disk has not taken it yet.
    pub(super) fn latch(&self, cause: Text, verified: bool) {
        self.0.leave(|stops| {
            let first = stops.stop.take().map_or(cause, |(first, _)| first);
            stops.stop = Some((first, verified));
        });
    }

    /// Waits until all stops are latched, and takes the records away that no stop needed.
    pub(super) fn finish(&self) {
        self.0.leave(|stops| stops.disarm = true);
        drop(
            self.0
                .wait(|stops| stops.busy || stops.disarm || stops.stop.is_some()),
        );
    }
}

/// Latches a stop for all adapters; a disk that refuses is tried again.
fn latch(records: &mut [Armed], cause: &str, verified: bool, teller: &Teller) {
    let clock = RunClock::start();
    for record in records {
        let mut tries = 0;
        while let Err(errno) = record.latch(cause, verified) {
            tries += 1;
            if tries == 1 {
                teller.tell(format_args!(
                    "the stop could not be latched: {}",
                    errno.desc()
                ));
            }
            if tries == TRIES {
                break;
            }
            clock.sleep_until(clock.now() + RETRY);
        }
    }
}
