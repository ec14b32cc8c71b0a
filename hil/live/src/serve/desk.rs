//! Desk between a study's session and its two pages: the view of each page, and the messages from it.
//!
//! A page names its person once, and where pages have tokens it has that person's. It then gets its view whenever that
//! changes. Its messages go into a queue for the session, but STOP: that is noted at once, on the thread that hears it.
//! The queue has a bound, whatever a page sends.

use std::collections::VecDeque;
use std::net::{SocketAddr, TcpStream};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Condvar, Mutex, PoisonError};
use std::time::{Duration, Instant};

use palpate_run::Failure;
use palpate_study::Reply;
use serde::Deserialize;
use serde_json::{Value, json};
use tungstenite::Message;

use super::files::Page;
use super::server::{self, Show, converse, socket, widen};
use super::slot::Slot;
use crate::clock;
use crate::lock::held;

/// Longest message of the participant's page, bytes: a drawing of ten minutes at 120 Hz. The experimenter's has a few words.
const LONGEST: usize = 8 << 20;
/// Words of pages that wait for the session at most. It takes them up between two stimuli.
const MOST_WAITING: usize = 64;
/// Persons of the pages, in the order of their tokens, with their paths.
const PAGES: [(Who, &str); 2] = [(Who::Participant, ""), (Who::Experimenter, "experimenter")];
/// Time after which a silent page counts as lost; a page sends something every second.
const SILENT: Duration = Duration::from_secs(3);

/// Message from a page.
#[derive(Debug, Clone, PartialEq)]
pub enum Heard {
    /// The participant's reply to the view of this number.
    Reply(u64, Reply),
    /// The experimenter's note.
    Note(String),
    /// The experimenter: the object to be laid under the finger lies there.
    Laid,
    /// The experimenter: the trial is void, for this reason.
    Void(String),
    /// STOP, on either page.
    Stop,
    /// The participant's page went away.
    Lost,
}

/// The desk of a session.
#[derive(Debug, Clone)]
pub struct Desk {
    shared: Arc<Shared>,
    /// The participant's page, with its token if it needs one.
    pub url: String,
    /// The experimenter's page, with another token.
    pub experimenter_url: String,
}

#[derive(Debug, Default)]
struct Shared {
    state: Mutex<State>,
    changed: Condvar,
    stop: AtomicBool,
}

#[derive(Debug, Default)]
struct State {
    participant: Shown,
    experimenter: Shown,
    heard: VecDeque<Heard>,
    stopped: Option<Instant>,
}

/// The view that all pages of one person show.
#[derive(Debug, Default)]
struct Shown {
    /// The number of the newest view; it grows with each.
    number: u64,
    view: Value,
    /// The slots of the pages. A participant has one at most: a newer page takes an older one's place.
    pages: Vec<Arc<Slot>>,
}

impl Shown {
    fn text(&self) -> Arc<str> {
        let told = json!({ "view": self.number, "shows": self.view });
        told.to_string().into()
    }

    /// Shows a view that this makes of the last one, and returns its number.
    fn change(&mut self, change: impl FnOnce(&mut Value)) -> u64 {
        change(&mut self.view);
        self.number += 1;
        let text = self.text();
        self.pages.iter().for_each(|page| page.show(0, &text));
        self.number
    }
}

impl State {
    /// Queues a message for the session; `false` where too many wait already.
    fn wait(&mut self, heard: Heard) -> bool {
        let is_word = matches!(heard, Heard::Note(_) | Heard::Void(_) | Heard::Laid);
        if is_word && self.heard.len() >= MOST_WAITING {
            return false;
        }
        let shown = self.participant.number;
        let is_known = match &heard {
            // Of a view the first reply counts, and none to a view that is gone.
            Heard::Reply(view, _) if *view == shown => {
                let is_old = |other: &Heard| matches!(other, Heard::Reply(to, _) if *to != shown);
                self.heard.retain(|other| !is_old(other));
                let mut waiting = self.heard.iter();
                waiting.any(|other| matches!(other, Heard::Reply(..)))
            }
            Heard::Reply(..) => true,
            Heard::Lost | Heard::Stop => self.heard.contains(&heard),
            _ => false,
        };
        if !is_known {
            self.heard.push_back(heard);
        }
        true
    }

    const fn shown(&mut self, who: Who) -> &mut Shown {
        match who {
            Who::Participant => &mut self.participant,
            Who::Experimenter => &mut self.experimenter,
        }
    }

    /// The experimenter sees at once whether the participant's page is there.
    fn tell_seated(&mut self) {
        let seated = !self.participant.pages.is_empty();
        let view = &self.experimenter.view;
        if view.is_object() && view["seated"] != json!(seated) {
            self.experimenter
                .change(|view| view["seated"] = json!(seated));
        }
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
enum Who {
    Participant,
    Experimenter,
}

/// Message that a page sends.
#[derive(Debug, Default, Deserialize)]
#[serde(default, deny_unknown_fields)]
struct Said {
    who: Option<Who>,
    /// Number of the view that a reply is to.
    view: u64,
    reply: Option<Reply>,
    note: Option<String>,
    laid: bool,
    void: Option<String>,
    stop: bool,
    /// Sign of life.
    alive: bool,
}

impl Shared {
    fn hear(&self, heard: Heard) -> bool {
        let waits = held(&self.state).wait(heard);
        self.changed.notify_all();
        waits
    }

    fn stop(&self) {
        // First of all: a run looks at this once every turn.
        self.stop.store(true, Ordering::Relaxed);
        let mut state = held(&self.state);
        state.stopped.get_or_insert(clock::now());
        state.wait(Heard::Stop);
        drop(state);
        self.changed.notify_all();
    }

    /// Takes a page's message; `false` for a text that is none, or for one too many.
    fn said(&self, who: Who, text: &str) -> bool {
        let Ok(said) = serde_json::from_str::<Said>(text) else {
            return false;
        };
        if said.stop {
            self.stop();
        }
        let heard = match who {
            Who::Participant => {
                let reply = said.reply.map(|reply| Heard::Reply(said.view, reply));
                [reply, None, None]
            }
            Who::Experimenter => [
                said.note.map(Heard::Note),
                said.void.map(Heard::Void),
                said.laid.then_some(Heard::Laid),
            ],
        };
        heard.into_iter().flatten().all(|heard| self.hear(heard))
    }

    /// Opens a new page, which gets the newest view.
    fn open(&self, who: Who) -> Arc<Slot> {
        let slot = Arc::new(Slot::default());
        let mut state = held(&self.state);
        let shown = state.shown(who);
        slot.show(0, &shown.text());
        if who == Who::Participant
            && let Some(older) = shown.pages.pop()
        {
            older.close();
            // The older page will not finish its message.
            state.wait(Heard::Lost);
        }
        state.shown(who).pages.push(Arc::clone(&slot));
        state.tell_seated();
        drop(state);
        self.changed.notify_all();
        slot
    }

    fn close(&self, who: Who, slot: &Arc<Slot>) {
        let mut state = held(&self.state);
        let pages = &mut state.shown(who).pages;
        let own = pages.iter().position(|page| Arc::ptr_eq(page, slot));
        let left = own.map(|own| pages.swap_remove(own));
        if who == Who::Participant && left.is_some() {
            state.wait(Heard::Lost);
        }
        state.tell_seated();
        drop(state);
        self.changed.notify_all();
    }
}

impl Show for Shared {
    fn look(&self) -> Page {
        Page::Study
    }

    fn page(&self, stream: TcpStream, shown: Option<usize>) {
        if stream.set_read_timeout(Some(SILENT)).is_err() {
            return;
        }
        let mut words = socket(stream);
        let first = match words.read() {
            Ok(Message::Text(text)) => serde_json::from_str::<Said>(&text).ok(),
            _ => None,
        };
        let Some(who) = first.and_then(|said| said.who) else {
            return;
        };
        if shown.is_some_and(|page| PAGES[page].0 != who) {
            return;
        }
        if who == Who::Participant {
            widen(&mut words, LONGEST);
        }
        let slot = self.open(who);
        converse(words, &slot, |text| self.said(who, text));
        self.close(who, &slot);
    }
}

impl Desk {
    /// Listens at an address; port 0 takes a free one.
    ///
    /// # Errors
    /// [`Failure::Device`] where that is not possible.
    pub fn open(address: SocketAddr) -> Result<Self, Failure> {
        let shared = Arc::new(Shared::default());
        let paths = PAGES.map(|(_, path)| path);
        let [url, experimenter_url] = server::serve(address, paths, Arc::clone(&shared) as _)?;
        Ok(Self {
            shared,
            url,
            experimenter_url,
        })
    }

    /// Tells whether STOP was heard; a run asks this once every turn.
    #[must_use]
    pub fn is_stopped(&self) -> bool {
        self.shared.stop.load(Ordering::Relaxed)
    }

    /// Time at which STOP was heard, if it was.
    #[must_use]
    pub fn stopped(&self) -> Option<Instant> {
        held(&self.shared.state).stopped
    }

    /// Tells whether the participant's page is there.
    #[must_use]
    pub fn is_seated(&self) -> bool {
        !held(&self.shared.state).participant.pages.is_empty()
    }

    /// Shows the participant a view, and returns its number, which a reply has to name.
    pub fn show(&self, view: Value) -> u64 {
        held(&self.shared.state)
            .participant
            .change(|last| *last = view)
    }

    /// Shows the experimenter something.
    pub fn tell(&self, view: Value) {
        held(&self.shared.state)
            .experimenter
            .change(|last| *last = view);
    }

    /// Shows the experimenter how much of the limits is used, and leaves the rest of the view as it is.
    pub fn limits(&self, rows: &[(&str, f64)]) {
        let mut state = held(&self.shared.state);
        let shown = &mut state.experimenter;
        if shown.view.is_object() {
            shown.change(|view| view["rows"] = json!(rows));
        }
    }

    /// Returns the next message, if one comes within `most`.
    #[must_use]
    pub fn hear(&self, most: Duration) -> Option<Heard> {
        let waits = |state: &mut State| state.heard.is_empty();
        let held = held(&self.shared.state);
        let waited = self.shared.changed.wait_timeout_while(held, most, waits);
        let mut state = waited.unwrap_or_else(PoisonError::into_inner).0;
        state.heard.pop_front()
    }
}

#[cfg(test)]
#[path = "desk_tests.rs"]
mod tests;
