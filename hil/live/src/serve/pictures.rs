//! Pictures of a run's pages, from its loop. The loop copies the data of a picture, and a thread paints it in its own
//! time. Neither waits for the other, and the loop wakes no thread: that would cost it more than the copy.

use std::fmt;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, TryLockError};
use std::thread::{Builder, JoinHandle, park, park_timeout};
use std::time::{Duration as Elapsed, Instant as Clock};

use palpate_core::units::{Duration, Instant};
use palpate_records::trace::Event;
use palpate_run::picture::{Painter, Picture, State};
use palpate_run::{Beginning, Failure, TurnView, Wish};
use serde::Serialize;

use super::live::{Hub, Live};
use crate::clock;
use crate::lock::held;

/// Time between two pictures.
const EVERY: Duration = Duration::from_micros(33_333);
/// Delay of the thread's look after a picture is due: the loop's turns are up to a millisecond apart.
const LATE: Elapsed = Elapsed::from_micros(500);
/// First pause after a look that found nothing. Each one after it is twice as long, up to a picture's time.
const SOON: Elapsed = Elapsed::from_millis(1);

/// A run's end of a live view.
pub struct LiveRun {
    hub: Arc<Hub>,
    studio: Arc<Studio>,
    shown: Vec<Shown>,
    painting: Option<JoinHandle<()>>,
}

/// State that the loop and the thread that paints share.
#[derive(Debug, Default)]
struct Studio {
    easels: Mutex<Vec<Arc<Mutex<Easel>>>>,
    is_over: AtomicBool,
}

/// A display of the run, with the loop's state of it.
struct Shown {
    easel: Arc<Mutex<Easel>>,
    next: Instant,
    /// Events of the display that have been looked at, and pictures that were due.
    told: usize,
    number: u64,
}

/// A display's painter, and the data of its next picture.
#[derive(Debug)]
struct Easel {
    painter: Painter,
    number: u64,
    /// Events for the picture. The vector keeps its memory from picture to picture, and so does `counts`.
    events: Vec<Event>,
    counts: Vec<f32>,
    /// State of the picture; `None` once it is painted.
    state: Option<State>,
    /// Time at which events, counts and state were copied: the thread keeps in step with the loop by this.
    at: Clock,
}

/// A picture on its way to the pages.
#[derive(Debug, Serialize)]
struct Made {
    display: usize,
    number: u64,
    picture: Picture,
}

/// A lock, if it is free: waiting is a call of the system, for both threads.
fn free<T>(lock: &Mutex<T>) -> Option<MutexGuard<'_, T>> {
    match lock.try_lock() {
        Ok(held) => Some(held),
        Err(TryLockError::Poisoned(held)) => Some(held.into_inner()),
        Err(TryLockError::WouldBlock) => None,
    }
}

impl fmt::Debug for LiveRun {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("LiveRun")
            .field("displays", &self.shown.len())
            .finish_non_exhaustive()
    }
}

impl LiveRun {
    /// A run's end of a live view, for a run that is about to begin.
    ///
    /// # Errors
    /// [`Failure::Device`] when the system gives no thread.
    pub fn begin(live: &Live) -> Result<Self, Failure> {
        let hub = live.hub();
        let studio = Arc::new(Studio::default());
        let paint = {
            let (studio, hub) = (Arc::clone(&studio), Arc::clone(&hub));
            move || studio.paint(&hub)
        };
        let painting = Builder::new().name("pictures".into()).spawn(paint);
        let painting = painting.map_err(|e| Failure::Device(format!("the live view: {e}")))?;
        hub.wakes(painting.thread());
        Ok(Self {
            hub,
            studio,
            shown: Vec::new(),
            painting: Some(painting),
        })
    }

    /// Adds the run that is about to begin, or one more of its displays.
    pub fn add(&mut self, run: &Beginning<'_>) {
        let easel = Arc::new(Mutex::new(Easel {
            painter: Painter::new(run.setup, run.header, run.projector),
            number: 0,
            events: Vec::new(),
            counts: Vec::new(),
            state: None,
            at: clock::now(),
        }));
        self.shown.push(Shown {
            easel: Arc::clone(&easel),
            next: Instant::ZERO,
            told: 0,
            number: 0,
        });
        held(&self.studio.easels).push(easel);
        self.hub.add(run);
    }

    /// Wish of a page since the last call.
    pub fn wish(&self) -> Option<Wish> {
        self.hub.wish()
    }

    /// Tells whether a page has said STOP.
    pub fn is_stopped(&self) -> bool {
        self.hub.is_stopped()
    }

    /// Shows a turn, if a picture is due that a page looks at.
    pub fn turn(&mut self, seen: &TurnView<'_>) {
        let Some(shown) = self
            .shown
            .get_mut(seen.display)
            .filter(|s| seen.now >= s.next)
        else {
            return;
        };
        // Being painted: the next turn is soon enough.
        let Some(mut easel) = free(&shown.easel) else {
            return;
        };
        shown.next = (shown.next + EVERY).max(seen.now);
        shown.number += 1;
        let events = seen.events.get(shown.told..).unwrap_or_default();
        shown.told = seen.events.len();
        easel.clear();
        if self.hub.looks_at(seen.display) {
            easel.number = shown.number;
            easel.events.extend_from_slice(events);
            easel.counts.extend_from_slice(seen.counts);
            let wants = easel.painter.wants(seen.now.as_micros());
            easel.state = Some((seen.state)(wants));
            easel.at = clock::now();
        } else {
            easel.painter.pass(events);
        }
    }
}

impl Drop for LiveRun {
    /// Shows the last picture before the pages hear of the run's end.
    fn drop(&mut self) {
        self.studio.is_over.store(true, Ordering::Release);
        if let Some(painting) = self.painting.take() {
            painting.thread().unpark();
            // A panic of the thread has been reported already.
            let _ = painting.join();
        }
    }
}

impl Studio {
    /// Paints until the run is over.
    fn paint(&self, hub: &Hub) {
        let every = Elapsed::from_micros(EVERY.as_micros());
        let mut pause = SOON;
        loop {
            let is_over = self.is_over.load(Ordering::Acquire);
            let easels = held(&self.easels).clone();
            let mut newest = None;
            for (display, easel) in easels.iter().enumerate() {
                let painted = free(easel).and_then(|mut easel| easel.paint(display));
                let Some((made, at)) = painted else {
                    continue;
                };
                newest = newest.max(Some(at));
                // A picture that cannot be JSON would be a fault of ours, and every picture stands for itself.
                if let Ok(text) = serde_json::to_string(&made) {
                    hub.show(display, &text.into());
                }
            }
            if is_over {
                return;
            }
            if !hub.is_watched() {
                park();
            } else if let Some(at) = newest {
                pause = SOON;
                park_timeout((every + LATE).saturating_sub(at.elapsed()));
            } else {
                park_timeout(pause);
                pause = every.min(pause * 2);
            }
        }
    }
}

impl Easel {
    /// Makes room for a newer picture. One that was not painted in time is never shown.
    fn clear(&mut self) {
        if self.state.take().is_some() {
            self.painter.pass(&self.events);
        }
        self.events.clear();
        self.counts.clear();
    }

    /// Paints the picture, if there is a new one. Returns it with the time of its copy.
    fn paint(&mut self, display: usize) -> Option<(Made, Clock)> {
        let state = self.state.take()?;
        let picture = self.painter.picture(&self.events, &self.counts, state);
        let made = Made {
            display,
            number: self.number,
            picture,
        };
        Some((made, self.at))
    }
}
