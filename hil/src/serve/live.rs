//! The live view of a run: pictures go from the loop to a thread, and from there to every page. The loop never waits
//! for either.

use std::fmt;
use std::net::{SocketAddr, TcpStream};
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::mpsc::{SyncSender, sync_channel};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread::Builder;
use std::time::Duration as Elapsed;

use palpate_core::units::{Duration, Instant};
use palpate_run::picture::{Head, Painter, Picture};
use palpate_run::{Beginning, Failure, TurnView};
use serde::{Deserialize, Serialize};
use serde_json::json;
use tungstenite::Message;

use super::files::Page;
use super::server::{self, Show, socket};
use super::slot::Slot;

/// Time between two pictures.
const EVERY: Duration = Duration::from_micros(33_333);
/// Pictures that wait for the thread that hands them on.
const WAITING: usize = 4;
/// Pages have so long to take in how the run ended.
const LAST: Elapsed = Elapsed::from_millis(500);
/// Displays that can be told apart.
const DISPLAYS: usize = 64;

/// A server of live views.
#[derive(Clone, Debug)]
pub struct Live {
    hub: Arc<Hub>,
    /// The page's address, with its token if it has one.
    pub url: String,
}

/// What pages and the run have in common.
#[derive(Debug, Default)]
struct Hub {
    pages: Mutex<Vec<Arc<Slot>>>,
    run: Mutex<Known>,
    /// Displays that pages look at, a bit each.
    looked_at: AtomicU64,
    stop: AtomicBool,
}

/// What a page is told that opens while the run goes on.
#[derive(Debug, Default)]
struct Known {
    /// A run's number: a page that comes back finds another one's pictures no part of what it has.
    run: u64,
    heads: Vec<Head>,
    names: Vec<String>,
    end_us: u64,
    over: Option<Arc<str>>,
}

/// What a page says.
#[derive(Debug, Default, Deserialize)]
#[serde(default, deny_unknown_fields)]
struct Said {
    stop: bool,
    display: Option<usize>,
}

fn held<T>(lock: &Mutex<T>) -> MutexGuard<'_, T> {
    lock.lock().unwrap_or_else(PoisonError::into_inner)
}

impl Known {
    fn hello(&self) -> Arc<str> {
        let Self {
            run,
            heads,
            names,
            end_us,
            ..
        } = self;
        let hello =
            json!({ "run": run.to_string(), "heads": heads, "names": names, "end_us": end_us });
        json!({ "hello": hello }).to_string().into()
    }
}

impl Live {
    /// Listens at an address; port 0 takes a free one.
    ///
    /// # Errors
    /// [`Failure::Device`] where that is not possible.
    pub fn open(address: SocketAddr) -> Result<Self, Failure> {
        let hub = Arc::new(Hub::default());
        held(&hub.run).run = u64::from_le_bytes(crate::link::key::random()?);
        let url = server::serve(address, Arc::clone(&hub) as _)?;
        Ok(Self { hub, url })
    }

    /// The run's end of it.
    ///
    /// # Errors
    /// [`Failure::Device`] when the system gives no thread.
    pub fn begin(&self) -> Result<LiveRun, Failure> {
        let (pictures, arriving) = sync_channel::<Made>(WAITING);
        let hub = Arc::clone(&self.hub);
        let hand_on = move || {
            for made in arriving {
                // What can be no JSON would be a fault of ours, and every picture stands for itself.
                let Ok(text) = serde_json::to_string(&made) else {
                    continue;
                };
                let text: Arc<str> = text.into();
                held(&hub.pages)
                    .iter()
                    .for_each(|page| page.show(made.display, &text));
            }
        };
        let thread = Builder::new().name("pictures".into()).spawn(hand_on);
        thread.map_err(|e| Failure::Device(format!("the live view: {e}")))?;
        Ok(LiveRun {
            hub: Arc::clone(&self.hub),
            shown: Vec::new(),
            pictures,
        })
    }

    /// The run is over, and this is what it came to; pages have a moment to take it in.
    pub fn over(&self, line: &str) {
        let text: Arc<str> = json!({ "over": line }).to_string().into();
        held(&self.hub.run).over = Some(Arc::clone(&text));
        let pages = held(&self.hub.pages).clone();
        pages.iter().for_each(|page| page.tell(Arc::clone(&text)));
        pages.iter().for_each(|page| page.drained(LAST));
    }
}

/// A picture on its way to the pages.
#[derive(Debug, Serialize)]
struct Made {
    display: usize,
    number: u64,
    picture: Picture,
}

/// A display of the run.
struct Shown {
    painter: Painter,
    next: Instant,
    /// How many of its events have been looked at, and how many pictures were due.
    told: usize,
    number: u64,
}

/// A run's end of a live view.
pub struct LiveRun {
    hub: Arc<Hub>,
    shown: Vec<Shown>,
    pictures: SyncSender<Made>,
}

impl fmt::Debug for LiveRun {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("LiveRun")
            .field("displays", &self.shown.len())
            .finish_non_exhaustive()
    }
}

impl LiveRun {
    /// The run is about to begin, or that of one more display.
    pub fn add(&mut self, run: &Beginning<'_>) {
        self.shown.push(Shown {
            painter: Painter::new(run.setup, run.header, run.projector),
            next: Instant::ZERO,
            told: 0,
            number: 0,
        });
        let mut known = held(&self.hub.run);
        known
            .heads
            .push(Head::new(run.setup, run.header, run.projector));
        known.names.push(run.display.unwrap_or_default().to_owned());
        known.end_us = run.end.as_micros();
        let hello = known.hello();
        drop(known);
        held(&self.hub.pages)
            .iter()
            .for_each(|page| page.tell(Arc::clone(&hello)));
    }

    /// Whether a page has said STOP.
    pub fn is_stopped(&self) -> bool {
        self.hub.stop.load(Ordering::Relaxed)
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
        shown.next = (shown.next + EVERY).max(seen.now);
        shown.number += 1;
        let events = seen.events.get(shown.told..).unwrap_or_default();
        shown.told = seen.events.len();
        let bit = 1 << seen.display.min(DISPLAYS - 1);
        if self.hub.looked_at.load(Ordering::Relaxed) & bit == 0 {
            shown.painter.pass(events);
            return;
        }
        let state = (seen.state)(shown.painter.wants(seen.now.as_micros()));
        let made = Made {
            display: seen.display,
            number: shown.number,
            picture: shown.painter.picture(events, seen.counts, state),
        };
        // Full: what is on its way is enough, and the pages count what they miss.
        let _ = self.pictures.try_send(made);
    }
}

impl Hub {
    fn look_again(&self) {
        let pages = held(&self.pages);
        let bits = pages
            .iter()
            .map(|page| 1 << page.display.load(Ordering::Relaxed).min(DISPLAYS - 1));
        self.looked_at
            .store(bits.fold(0, |all, bit: u64| all | bit), Ordering::Relaxed);
    }

    fn open(&self) -> Arc<Slot> {
        let slot = Arc::new(Slot::default());
        let known = held(&self.run);
        if !known.heads.is_empty() {
            slot.tell(known.hello());
        }
        known
            .over
            .iter()
            .for_each(|over| slot.tell(Arc::clone(over)));
        // Still under the lock: what is told from here on reaches this page too.
        held(&self.pages).push(Arc::clone(&slot));
        drop(known);
        self.look_again();
        slot
    }

    fn close(&self, slot: &Slot) {
        slot.close();
        held(&self.pages).retain(|page| !page.is_gone());
        self.look_again();
    }

    /// What a page says; false for what is no message of a page.
    fn hear(&self, slot: &Slot, text: &str) -> bool {
        let Ok(said) = serde_json::from_str::<Said>(text) else {
            return false;
        };
        if said.stop {
            self.stop.store(true, Ordering::Relaxed);
        }
        if let Some(display) = said.display {
            slot.display.store(display, Ordering::Relaxed);
            self.look_again();
        }
        true
    }
}

impl Show for Hub {
    fn look(&self) -> Page {
        Page::Live
    }

    /// Reads on this thread, so that a STOP waits for no picture; another one writes.
    fn page(&self, stream: TcpStream) {
        let Ok(out) = stream.try_clone() else {
            return;
        };
        let (slot, longest) = (self.open(), self.longest());
        let write = {
            let slot = Arc::clone(&slot);
            move || {
                let mut out = socket(out, longest);
                while let Some(text) = slot.next() {
                    if out.send(Message::text(&*text)).is_err() {
                        break;
                    }
                }
                slot.close();
                // Wakes the reader.
                let _ = out.get_ref().shutdown(std::net::Shutdown::Both);
            }
        };
        let writer = Builder::new().name("page".into()).spawn(write);
        let mut words = socket(stream, longest);
        while writer.is_ok() {
            match words.read() {
                Ok(Message::Text(text)) if self.hear(&slot, &text) => {}
                Ok(Message::Ping(_) | Message::Pong(_)) => {}
                _ => break,
            }
        }
        self.close(&slot);
    }
}
