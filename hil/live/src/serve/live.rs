//! The live view of a run: the state that a page gets when it opens, the display that it looks at, its messages.

use std::collections::BTreeMap;
use std::net::{SocketAddr, TcpStream};
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, Mutex};
use std::thread::Thread;
use std::time::Duration;

use palpate_records::margin::Margin;
use palpate_run::picture::Head;
use palpate_run::{Beginning, Failure, Wish};
use serde::Deserialize;
use serde_json::json;

use crate::lock::held;

use super::files::Page;
use super::server::{self, Show, converse, socket};
use super::slot::Slot;

/// Time for pages to take in the end of the run.
const LAST: Duration = Duration::from_millis(500);
/// Most displays that are told apart.
const DISPLAYS: usize = 64;

/// A server of live views.
#[derive(Clone, Debug)]
pub struct Live {
    hub: Arc<Hub>,
    /// The page's address, with its token if it has one.
    pub url: String,
}

/// State that pages and the run share.
#[derive(Debug, Default)]
pub(super) struct Hub {
    pages: Mutex<Vec<Arc<Slot>>>,
    run: Mutex<RunState>,
    /// Displays that pages look at, a bit each.
    looked_at: AtomicU64,
    /// The newest picture of each display, for pages that open when no other comes.
    newest: Mutex<BTreeMap<usize, Arc<str>>>,
    /// The thread that paints for them, asleep while no page looks.
    painting: Mutex<Option<Thread>>,
    stop: AtomicBool,
    /// The newest wish that no run has taken.
    wish: Mutex<Option<Wish>>,
    /// `true` once a page has opened.
    seen: AtomicBool,
}

/// State of the run for a page that opens while it goes on.
#[derive(Debug, Default)]
struct RunState {
    /// Number of the run: a page that comes back drops pictures of another run.
    run: u64,
    heads: Vec<Head>,
    names: Vec<String>,
    end_us: u64,
    over: Option<Arc<str>>,
}

/// Message that a page sends.
#[derive(Debug, Default, Deserialize)]
#[serde(default, deny_unknown_fields)]
struct Said {
    stop: bool,
    rezero: bool,
    hot_pass: bool,
    display: Option<usize>,
}

impl RunState {
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
        let [url] = server::serve(address, [""], Arc::clone(&hub) as _)?;
        let live = Self { hub, url };
        live.again()?;
        Ok(live)
    }

    /// Another run follows, or the first one; pages stay.
    ///
    /// # Errors
    /// [`Failure::Device`] for a system without random bytes.
    pub fn again(&self) -> Result<(), Failure> {
        *held(&self.hub.run) = RunState {
            run: u64::from_le_bytes(crate::link::key::random()?),
            ..RunState::default()
        };
        held(&self.hub.newest).clear();
        held(&self.hub.pages).iter().for_each(|page| page.forget());
        Ok(())
    }

    /// Tells whether a page has opened.
    #[must_use]
    pub fn is_seen(&self) -> bool {
        self.hub.seen.load(Ordering::Relaxed)
    }

    /// Tells whether a page has said STOP; a run asks this once every turn.
    #[must_use]
    pub fn is_stopped(&self) -> bool {
        self.hub.is_stopped()
    }

    /// State that its pages share with a run.
    pub(super) fn hub(&self) -> Arc<Hub> {
        Arc::clone(&self.hub)
    }

    /// Tells pages that the run is over, with its summary and the measured share of each limit. Pages have a moment to
    /// take it in.
    pub fn over(&self, line: &str, margins: &[Margin]) {
        let measured = margins.iter().map(|m| (m.of.name(), m.used_words()));
        let measured: Vec<_> = measured.collect();
        let text: Arc<str> = json!({ "over": line, "measured": measured })
            .to_string()
            .into();
        held(&self.hub.run).over = Some(Arc::clone(&text));
        let pages = held(&self.hub.pages).clone();
        pages.iter().for_each(|page| page.tell(Arc::clone(&text)));
        pages.iter().for_each(|page| page.drained(LAST));
    }
}

impl Hub {
    /// Adds a display of the run.
    pub(super) fn add(&self, run: &Beginning<'_>) {
        let mut known = held(&self.run);
        known
            .heads
            .push(Head::new(run.setup, run.header, run.projector));
        known.names.push(run.display.unwrap_or_default().to_owned());
        known.end_us = run.end.as_micros();
        let hello = known.hello();
        drop(known);
        held(&self.pages)
            .iter()
            .for_each(|page| page.tell(Arc::clone(&hello)));
    }

    /// Tells whether a page has said STOP.
    pub(super) fn is_stopped(&self) -> bool {
        self.stop.load(Ordering::Relaxed)
    }

    /// Takes the newest wish. A lock that a page has meanwhile is not waited for: the next turn asks again.
    pub(super) fn wish(&self) -> Option<Wish> {
        self.wish.try_lock().ok()?.take()
    }

    /// Tells whether any page looks at a display.
    pub(super) fn is_watched(&self) -> bool {
        self.looked_at.load(Ordering::Relaxed) != 0
    }

    /// Tells whether a page looks at this display.
    pub(super) fn looks_at(&self, display: usize) -> bool {
        let bit = 1 << display.min(DISPLAYS - 1);
        self.looked_at.load(Ordering::Relaxed) & bit != 0
    }

    /// Has a thread woken whenever pages look elsewhere; and now, since a page may have come before this call.
    pub(super) fn wakes(&self, painting: &Thread) {
        *held(&self.painting) = Some(painting.clone());
        painting.unpark();
    }

    /// Sends the newest picture of a display to all pages that look at it.
    pub(super) fn show(&self, display: usize, picture: &Arc<str>) {
        held(&self.newest).insert(display, Arc::clone(picture));
        held(&self.pages)
            .iter()
            .for_each(|page| page.show(display, picture));
    }

    fn look_again(&self) {
        let pages = held(&self.pages);
        let bits = pages
            .iter()
            .map(|page| 1 << page.display().min(DISPLAYS - 1));
        self.looked_at
            .store(bits.fold(0, |all, bit: u64| all | bit), Ordering::Relaxed);
        drop(pages);
        held(&self.painting).iter().for_each(Thread::unpark);
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
        if known.over.is_some() {
            self.show_last(&slot, 0);
        }
        // Still under the lock: messages from here on reach this page too.
        held(&self.pages).push(Arc::clone(&slot));
        drop(known);
        self.look_again();
        self.seen.store(true, Ordering::Relaxed);
        slot
    }

    /// Shows the newest picture of a display.
    fn show_last(&self, slot: &Slot, display: usize) {
        if let Some(picture) = held(&self.newest).get(&display) {
            slot.show(display, picture);
        }
    }

    /// Takes a page's message. Returns `false` for text that is no message of a page.
    fn hear(&self, slot: &Slot, text: &str) -> bool {
        let Ok(said) = serde_json::from_str::<Said>(text) else {
            return false;
        };
        if said.stop {
            self.stop.store(true, Ordering::Relaxed);
        }
        let rezero = said.rezero.then_some(Wish::Rezero { forced: false });
        if let Some(wish) = said.hot_pass.then_some(Wish::HotPass).or(rezero) {
            *held(&self.wish) = Some(wish);
        }
        if let Some(display) = said.display {
            slot.look_at(display);
            if held(&self.run).over.is_some() {
                self.show_last(slot, display);
            }
            self.look_again();
        }
        true
    }
}

impl Show for Hub {
    fn look(&self) -> Page {
        Page::Live
    }

    fn page(&self, stream: TcpStream, _shown: Option<usize>) {
        let slot = self.open();
        let words = socket(stream);
        converse(words, &slot, |text| self.hear(&slot, text));
        held(&self.pages).retain(|page| !page.is_gone());
        self.look_again();
    }
}
