//! State that the clients of a run and the run share: its topics, and who listens.

use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, Mutex};
use std::time::Duration;

use tungstenite::Message;

use crate::lock::held;

use super::client::Client;
use super::words::{Channel, Level, Said, advertise, server_info, status, time, unadvertise};

/// The topics of a run, and its clients.
#[derive(Debug)]
pub(super) struct Hub {
    session: String,
    run: Mutex<Topics>,
    clients: Mutex<Vec<Arc<Client>>>,
    /// `true` once a client has come.
    seen: AtomicBool,
    left_out: AtomicU64,
}

/// The topics of the newest run.
#[derive(Debug, Default)]
pub(super) struct Topics {
    pub channels: Vec<Channel>,
    /// Messages from before the run's first moment, which every subscriber of their topic gets: topic, time in nanoseconds and
    /// payload.
    pub first: Vec<(u32, u64, Vec<u8>)>,
}

impl Hub {
    pub(super) fn new(session: String) -> Self {
        Self {
            session,
            run: Mutex::default(),
            clients: Mutex::default(),
            seen: AtomicBool::new(false),
            left_out: AtomicU64::new(0),
        }
    }

    /// Number of the first topic of the run that comes next.
    pub(super) fn next_id(&self) -> u32 {
        held(&self.run)
            .channels
            .last()
            .map_or(0, |last| last.id + 1)
    }

    /// Replaces the topics by those of a run that begins.
    pub(super) fn begin(&self, topics: Topics) {
        let mut run = held(&self.run);
        for client in &*held(&self.clients) {
            if !run.channels.is_empty() {
                client.unsubscribe_all();
                client.tell(unadvertise(&run.channels));
            }
            client.tell(advertise(&topics.channels));
        }
        *run = topics;
    }

    /// Takes a client in.
    pub(super) fn enter(&self) -> Arc<Client> {
        let client = Arc::new(Client::default());
        let run = held(&self.run);
        client.tell(server_info(&self.session));
        client.tell(advertise(&run.channels));
        // Still under the run's lock: whatever begins from here on reaches this client too.
        held(&self.clients).push(Arc::clone(&client));
        self.seen.store(true, Ordering::Relaxed);
        client
    }

    /// Forgets clients that have gone.
    pub(super) fn sweep(&self) {
        held(&self.clients).retain(|client| !client.is_gone());
    }

    /// Tells whether a client has come.
    pub(super) fn is_seen(&self) -> bool {
        self.seen.load(Ordering::Relaxed)
    }

    /// Takes a client's message. Returns `false` for text that is no message of the protocol.
    pub(super) fn hear(&self, client: &Client, text: &str) -> bool {
        let Ok(said) = serde_json::from_str(text) else {
            return false;
        };
        match said {
            Said::Subscribe { subscriptions } => {
                for wish in subscriptions {
                    self.subscribe(client, wish.channel_id, wish.id);
                }
            }
            Said::Unsubscribe { subscription_ids } => {
                subscription_ids
                    .iter()
                    .for_each(|id| client.unsubscribe(*id));
            }
            Said::Other => {
                let offered = "expected subscribe or unsubscribe: this server offers nothing else";
                client.tell(status(Level::Warning, offered));
            }
        }
        true
    }

    fn subscribe(&self, client: &Client, channel: u32, number: u32) {
        let run = held(&self.run);
        let refused = match run.channels.iter().any(|known| known.id == channel) {
            false => {
                format!("subscription {number}: expected an advertised channel, found {channel}")
            }
            true if client.subscribe(channel, number) => {
                let own = run.first.iter().filter(|(of, ..)| *of == channel);
                own.for_each(|(_, t_ns, payload)| {
                    self.count(client.publish(channel, *t_ns, payload))
                });
                return;
            }
            true => format!(
                "subscription {number}: expected a new number and one subscription to channel {channel}"
            ),
        };
        client.tell(status(Level::Error, &refused));
    }

    /// Counts a message that found no room.
    fn count(&self, found_room: bool) {
        if !found_room {
            self.left_out.fetch_add(1, Ordering::Relaxed);
        }
    }

    /// Sends a message of a topic to those who have subscribed to it.
    pub(super) fn publish(&self, channel: u32, t_ns: u64, payload: &[u8]) {
        for client in &*held(&self.clients) {
            self.count(client.publish(channel, t_ns, payload));
        }
    }

    /// Sends the time to all.
    pub(super) fn show(&self, t_ns: u64) {
        for client in &*held(&self.clients) {
            client.show(time(t_ns));
        }
    }

    /// Says a remark to all, who have so long to take in what waits for them.
    pub(super) fn last_words(&self, words: &str, most: Duration) {
        let clients = held(&self.clients).clone();
        let message: Message = status(Level::Info, words);
        clients
            .iter()
            .for_each(|client| client.tell(message.clone()));
        clients.iter().for_each(|client| client.drained(most));
    }

    /// Messages that found no room, of all clients.
    pub(super) fn left_out(&self) -> u64 {
        self.left_out.load(Ordering::Relaxed)
    }
}
