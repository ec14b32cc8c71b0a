//! Between a study's session and its two pages: what each page shows, and what was said on it.
//!
//! A page says once who it is. It is then told its view whenever that changes. Everything that it says goes into a queue for
//! the session, but STOP: that is noted at once, on the thread that hears it.

use std::collections::VecDeque;
use std::io::ErrorKind;
use std::net::{Shutdown, SocketAddr, TcpStream};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::thread::Builder;
use std::time::{Duration, Instant};

use palpate_core::guard::Used;
use palpate_run::Failure;
use palpate_study::Reply;
use serde::Deserialize;
use serde_json::{Value, json};
use tungstenite::Message;

use super::files::Page;
use super::server::{self, Show, socket};
use crate::clock;

/// Longest message of a page, bytes: a drawing of ten minutes at 120 Hz.
const LONGEST: usize = 8 << 20;
/// A page that says nothing for so long is lost; it says something every second.
const SILENT: Duration = Duration::from_secs(3);

/// What was said on a page.
#[derive(Debug, Clone, PartialEq)]
pub enum Heard {
    /// The participant's reply to the view of this number.
    Reply(u64, Reply),
    /// The experimenter's note.
    Note(String),
    /// The experimenter: what was to be laid under the finger lies there.
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
}

#[derive(Debug, Default)]
struct Shared {
    state: Mutex<State>,
    changed: Condvar,
    stop: AtomicBool,
}

#[derive(Debug, Default)]
struct State {
    /// Grows with every view of the participant.
    number: u64,
    participant: Value,
    experimenter: Value,
    /// Grows with every view of the experimenter.
    told: u64,
    heard: VecDeque<Heard>,
    /// The participant's page: a newer one takes an older one's place.
    seat: u64,
    seated: bool,
    stopped: Option<Instant>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
enum Who {
    Participant,
    Experimenter,
}

/// What a page says.
#[derive(Debug, Default, Deserialize)]
#[serde(default, deny_unknown_fields)]
struct Said {
    who: Option<Who>,
    /// The view that a reply is to.
    view: u64,
    reply: Option<Reply>,
    note: Option<String>,
    laid: bool,
    void: Option<String>,
    stop: bool,
    /// That it is there.
    alive: bool,
}

impl Shared {
    fn held(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn hear(&self, heard: Heard) {
        self.held().heard.push_back(heard);
        self.changed.notify_all();
    }

    fn stop(&self) {
        // First of all: a run looks at this once every turn.
        self.stop.store(true, Ordering::Relaxed);
        let mut state = self.held();
        state.stopped.get_or_insert(clock::now());
        state.heard.push_back(Heard::Stop);
        drop(state);
        self.changed.notify_all();
    }

    /// Takes in what a page said; false for what is no message of a page.
    fn said(&self, who: Who, text: &str) -> bool {
        let Ok(said) = serde_json::from_str::<Said>(text) else {
            return false;
        };
        if said.stop {
            self.stop();
        }
        match who {
            Who::Participant => {
                if let Some(reply) = said.reply {
                    self.hear(Heard::Reply(said.view, reply));
                }
            }
            Who::Experimenter => {
                if let Some(note) = said.note {
                    self.hear(Heard::Note(note));
                }
                if let Some(why) = said.void {
                    self.hear(Heard::Void(why));
                }
                if said.laid {
                    self.hear(Heard::Laid);
                }
            }
        }
        true
    }

    /// Sends a page its view whenever it changes, until it is gone.
    fn tell(&self, stream: TcpStream, who: Who, seat: u64, gone: &AtomicBool) {
        let mut out = socket(stream, LONGEST);
        let mut sent = None;
        let mut state = self.held();
        loop {
            if gone.load(Ordering::Relaxed) || (who == Who::Participant && state.seat != seat) {
                break;
            }
            let (number, view) = match who {
                Who::Participant => (state.number, &state.participant),
                Who::Experimenter => (state.told, &state.experimenter),
            };
            if sent == Some(number) {
                let waited = self.changed.wait_timeout(state, Duration::from_secs(1));
                state = waited.unwrap_or_else(PoisonError::into_inner).0;
                continue;
            }
            let text = json!({ "view": number, "shows": view }).to_string();
            sent = Some(number);
            drop(state);
            if out.send(Message::text(text)).is_err() {
                break;
            }
            state = self.held();
        }
        // Wakes the reader.
        let _ = out.get_ref().shutdown(Shutdown::Both);
    }
}

impl Show for Shared {
    fn look(&self) -> Page {
        Page::Study
    }

    fn longest(&self) -> usize {
        LONGEST
    }

    fn page(&self, stream: TcpStream) {
        let Ok(out) = stream.try_clone() else {
            return;
        };
        if stream.set_read_timeout(Some(SILENT)).is_err() {
            return;
        }
        let mut words = socket(stream, LONGEST);
        let first = match words.read() {
            Ok(Message::Text(text)) => serde_json::from_str::<Said>(&text).ok(),
            _ => None,
        };
        let Some(who) = first.and_then(|said| said.who) else {
            return;
        };
        let mut seat = 0;
        if who == Who::Participant {
            let mut state = self.held();
            if state.seated {
                // Whatever the older one was in the midst of, it will not say.
                state.heard.push_back(Heard::Lost);
            }
            state.seat += 1;
            (seat, state.seated) = (state.seat, true);
            drop(state);
            self.changed.notify_all();
        }
        let gone = AtomicBool::new(false);
        std::thread::scope(|scope| {
            let tell = || self.tell(out, who, seat, &gone);
            let writer = Builder::new().name("desk".into()).spawn_scoped(scope, tell);
            while writer.is_ok() {
                match words.read() {
                    Ok(Message::Text(text)) if self.said(who, &text) => {}
                    Ok(Message::Ping(_) | Message::Pong(_)) => {}
                    Err(tungstenite::Error::Io(e)) if e.kind() == ErrorKind::Interrupted => {}
                    _ => break,
                }
            }
            gone.store(true, Ordering::Relaxed);
            self.changed.notify_all();
        });
        if who == Who::Participant {
            let mut state = self.held();
            if state.seat == seat {
                state.seated = false;
                state.heard.push_back(Heard::Lost);
            }
            drop(state);
            self.changed.notify_all();
        }
    }
}

impl Desk {
    /// Listens at an address; port 0 takes a free one.
    ///
    /// # Errors
    /// [`Failure::Device`] where that is not possible.
    pub fn open(address: SocketAddr) -> Result<Self, Failure> {
        let shared = Arc::new(Shared::default());
        let url = server::serve(address, Arc::clone(&shared) as _)?;
        Ok(Self { shared, url })
    }

    /// The experimenter's page.
    #[must_use]
    pub fn experimenter_url(&self) -> String {
        match self.url.split_once('#') {
            Some((page, token)) => format!("{page}experimenter#{token}"),
            None => format!("{}experimenter", self.url),
        }
    }

    /// Whether STOP was heard; a run asks this once every turn.
    #[must_use]
    pub fn is_stopped(&self) -> bool {
        self.shared.stop.load(Ordering::Relaxed)
    }

    /// When STOP was heard, if it was.
    #[must_use]
    pub fn stopped(&self) -> Option<Instant> {
        self.shared.held().stopped
    }

    /// Whether the participant's page is there.
    #[must_use]
    pub fn is_seated(&self) -> bool {
        self.shared.held().seated
    }

    /// Shows the participant something, and returns its number: what a reply has to name.
    pub fn show(&self, view: Value) -> u64 {
        let mut state = self.shared.held();
        state.number += 1;
        state.participant = view;
        let number = state.number;
        drop(state);
        self.shared.changed.notify_all();
        number
    }

    /// Shows the experimenter something.
    pub fn tell(&self, view: Value) {
        let mut state = self.shared.held();
        state.told += 1;
        state.experimenter = view;
        drop(state);
        self.shared.changed.notify_all();
    }

    /// Shows the experimenter how much of the limits is used, and leaves the rest of the view as it is.
    pub fn limits(&self, used: &Used) {
        let mut state = self.shared.held();
        if state.experimenter.is_object() {
            state.told += 1;
            state.experimenter["rows"] = json!(used.rows());
        }
        drop(state);
        self.shared.changed.notify_all();
    }

    /// What was said next, if anything is within so long.
    #[must_use]
    pub fn hear(&self, most: Duration) -> Option<Heard> {
        let waits = |state: &mut State| state.heard.is_empty();
        let held = self.shared.held();
        let waited = self.shared.changed.wait_timeout_while(held, most, waits);
        let mut state = waited.unwrap_or_else(PoisonError::into_inner).0;
        state.heard.pop_front()
    }
}
