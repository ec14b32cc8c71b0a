//! The thread that reserves ahead. The loops show it their guards when it asks, and never wait for it or for a disk.

use std::io;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::{Builder, JoinHandle};
use std::time::Duration as Elapsed;

use palpate_core::guard::{Guard, Memory};
use palpate_core::units::{Duration, Instant};

use super::uptime::Uptime;
use super::{Books, LedgerError};
use crate::desk::Desk;

/// Time ahead for which heat is reserved: the cost of a death.
const SPAN: Duration = Duration::from_millis(4000);
/// Time between two reserves. The rest of a span is for a slow disk.
const RENEW: Elapsed = Elapsed::from_millis(1000);
/// Time before the end of a reserve at which outputs go off.
const MARGIN: Duration = Duration::from_millis(100);
/// Longest wait for the disk at the beginning and at the end, where nothing is driven.
const PATIENCE: Elapsed = Elapsed::from_secs(5);
/// Failure of a write that has no other known cause.
const SILENT: &str = "the disk does not answer";

/// A guard as its loop showed it.
#[derive(Debug)]
struct Shown {
    at: Instant,
    uptime: Uptime,
    guard: Guard,
}

impl Shown {
    fn new(at: Instant, guard: &Guard) -> Arc<Self> {
        Arc::new(Self {
            at,
            uptime: Uptime::now(),
            guard: guard.clone(),
        })
    }

    /// Memory that outlives the guard, and the time at which it holds: with the heat of all that the next seconds may
    /// bring, or as the guard is.
    fn outlives(&self, reserves: bool) -> (Uptime, Memory) {
        match reserves {
            true => (self.uptime.after(SPAN), self.guard.reserve(self.at, SPAN)),
            false => (self.uptime, self.guard.memory(self.at)),
        }
    }
}

/// State of the outputs at a run's end.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum End {
    /// Everything is known to be off.
    Off,
    /// Outputs may be on.
    Unknown,
    /// The run ended without a word.
    Unsaid,
}

/// State of a fingertip's loop.
#[derive(Debug)]
struct Part {
    shown: Arc<Shown>,
    /// `true` while the thread waits for a newer guard.
    is_old: bool,
    /// `true` once no newer guard will come.
    is_last: bool,
}

/// State that the loops and the thread share.
#[derive(Debug)]
struct Papers {
    parts: Vec<Part>,
    end: Option<End>,
    /// Reason for which the newest write failed.
    failed: Option<String>,
    /// `true` once nothing will be written any more.
    is_over: bool,
}

#[derive(Debug)]
struct Shared {
    desk: Desk<Papers>,
    /// `true` while the thread waits for a fingertip's guard.
    asked: Vec<AtomicBool>,
    /// End of the reserve on the disk, microseconds of the run.
    until_us: AtomicU64,
}

/// Accounts of a run with the thread that books there. Dropped without [`Self::end`], it leaves reserves booked.
#[derive(Debug)]
pub struct Keeper {
    shared: Arc<Shared>,
    thread: Mutex<Option<JoinHandle<()>>>,
}

impl Keeper {
    /// Returns once the first reserve is on the disk.
    ///
    /// # Errors
    /// [`LedgerError::Reserve`].
    pub(super) fn start(books: Books, states: &[(Instant, &Guard)]) -> Result<Self, LedgerError> {
        let part = |(at, guard): &(Instant, &Guard)| Part {
            shown: Shown::new(*at, guard),
            is_old: false,
            is_last: false,
        };
        let shared = Arc::new(Shared {
            asked: states.iter().map(|_| AtomicBool::new(false)).collect(),
            until_us: AtomicU64::new(0),
            desk: Desk::new(Papers {
                parts: states.iter().map(part).collect(),
                end: None,
                failed: None,
                is_over: false,
            }),
        });
        let own = Arc::clone(&shared);
        let thread = Builder::new().name("heat".into());
        let thread = thread.spawn(move || own.serve(&books));
        let thread = thread.map_err(|error| LedgerError::Reserve(error.to_string()))?;
        let keeper = Self {
            shared,
            thread: Mutex::new(Some(thread)),
        };
        let unwritten = |papers: &mut Papers| {
            papers.failed.is_none() && keeper.shared.until_us.load(Ordering::Acquire) == 0
        };
        let papers = keeper.shared.desk.wait_for(PATIENCE, unwritten);
        let failed = papers.failed.clone();
        drop(papers);
        match keeper.shared.until_us.load(Ordering::Acquire) {
            0 => Err(LedgerError::Reserve(
                failed.unwrap_or_else(|| SILENT.into()),
            )),
            _ => Ok(keeper),
        }
    }

    /// Shows a fingertip's guard before a turn at `now`, where that is asked for.
    ///
    /// # Errors
    /// [`LedgerError::Reserve`] where nothing is reserved for the turn: the outputs are to go off.
    pub fn beat(&self, fingertip: usize, now: Instant, guard: &Guard) -> Result<(), LedgerError> {
        let asked = self.shared.asked.get(fingertip);
        if asked.is_some_and(|asked| asked.load(Ordering::Acquire)) {
            self.shared.show(fingertip, now, guard, false);
        }
        let until_us = self.shared.until_us.load(Ordering::Acquire);
        match now + MARGIN <= Instant::from_micros(until_us) {
            true => Ok(()),
            false => Err(LedgerError::Reserve(self.shared.why())),
        }
    }

    /// Takes the guard of a fingertip's loop that ends before the others'.
    pub fn leave(&self, fingertip: usize, now: Instant, guard: &Guard) {
        self.shared.show(fingertip, now, guard, true);
    }

    /// Ends the run: true heat and dose take the place of the reserve, where everything is known to be `off`. `states`
    /// has the guards of all fingertips.
    ///
    /// # Errors
    /// [`LedgerError::Reserve`] with the reason why that could not be kept: the reserve stays booked.
    pub fn end(&self, states: &[(Instant, &Guard)], off: bool) -> Result<(), LedgerError> {
        self.shared.desk.leave(|papers| {
            for (part, (at, guard)) in papers.parts.iter_mut().zip(states) {
                part.shown = Shown::new(*at, guard);
            }
            papers.failed = None;
            papers.end = Some(match off {
                true => End::Off,
                false => End::Unknown,
            });
        });
        let goes_on = |papers: &mut Papers| !papers.is_over;
        let papers = self.shared.desk.wait_for(PATIENCE, goes_on);
        let (is_over, failed) = (papers.is_over, papers.failed.clone());
        drop(papers);
        if !is_over {
            return Err(LedgerError::Reserve(SILENT.into()));
        }
        // It lets go of its files: the next run may hold them.
        let thread = self
            .thread
            .lock()
            .unwrap_or_else(PoisonError::into_inner)
            .take();
        let _ = thread.map(JoinHandle::join);
        failed.map_or(Ok(()), |why| Err(LedgerError::Reserve(why)))
    }
}

impl Drop for Keeper {
    fn drop(&mut self) {
        self.shared.desk.leave(|papers| {
            papers.end.get_or_insert(End::Unsaid);
        });
    }
}

impl Shared {
    /// Leaves a guard where the thread is not at the desk at this moment.
    fn show(&self, fingertip: usize, now: Instant, guard: &Guard, is_last: bool) {
        let leave = |papers: &mut Papers| {
            let Some(part) = papers.parts.get_mut(fingertip) else {
                return;
            };
            part.shown = Shown::new(now, guard);
            (part.is_old, part.is_last) = (false, is_last);
            if let Some(asked) = self.asked.get(fingertip) {
                asked.store(false, Ordering::Release);
            }
        };
        match is_last {
            true => self.desk.leave(leave),
            false => self.desk.try_leave(leave),
        }
    }

    /// Reason for which nothing is reserved.
    fn why(&self) -> String {
        let failed = self.desk.left().failed.clone();
        failed.unwrap_or_else(|| SILENT.into())
    }

    /// Renews reserves until the end.
    fn serve(&self, books: &Books) {
        loop {
            let (shown, until) = self.taken();
            let written = write(books, &shown, true);
            if written.is_ok() {
                self.until_us.store(until.as_micros(), Ordering::Release);
            }
            self.desk.leave(|papers| papers.failed = written.err());
            let goes_on = |papers: &mut Papers| papers.end.is_none();
            drop(self.desk.wait_for(RENEW, goes_on));
            self.ask();
            let waits = |papers: &mut Papers| {
                papers.end.is_none() && papers.parts.iter().any(|part| part.is_old)
            };
            let end = self.desk.wait(waits).end;
            if let Some(end) = end {
                return self.finish(books, end);
            }
        }
    }

    /// Newest guards of all loops, and the end of a reserve from them, by the loops that go on.
    fn taken(&self) -> (Vec<Arc<Shown>>, Instant) {
        let papers = self.desk.left();
        let live = papers.parts.iter().filter(|part| !part.is_last);
        let until = live.map(|part| part.shown.at + SPAN).min();
        let shown = papers.parts.iter().map(|part| Arc::clone(&part.shown));
        (shown.collect(), until.unwrap_or(Instant::FAR_FUTURE))
    }

    /// Asks the loops that go on for their guards.
    fn ask(&self) {
        let mut papers = self.desk.left();
        for (part, asked) in papers.parts.iter_mut().zip(&self.asked) {
            part.is_old = !part.is_last;
            asked.store(part.is_old, Ordering::Release);
        }
    }

    /// Writes the accounts for the last time.
    fn finish(&self, books: &Books, end: End) {
        let (shown, _) = self.taken();
        let written = match end {
            End::Unsaid => Ok(()),
            End::Off | End::Unknown => write(books, &shown, end == End::Unknown),
        };
        self.desk.leave(|papers| {
            papers.failed = written.err();
            papers.is_over = true;
        });
    }
}

/// Writes the memory that outlives these guards. The error is the reason in words.
fn write(books: &Books, shown: &[Arc<Shown>], reserves: bool) -> Result<(), String> {
    let states: Vec<_> = shown.iter().map(|shown| shown.outlives(reserves)).collect();
    let written: io::Result<()> = books.write(&states);
    written.map_err(|error| error.to_string())
}
