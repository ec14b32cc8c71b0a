//! Mailbox of one client: its subscriptions, and messages on their way to it. A client that reads too slowly misses data,
//! and is told how much.

use std::collections::{BTreeMap, VecDeque};
use std::sync::{Condvar, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use tungstenite::Message;

use super::super::server::Mailbox;
use super::words::{Level, data, status};

/// Most bytes that wait for a client: some seconds of a hand.
pub(super) const MOST_WAITING: usize = 4 << 20;
/// Most bytes of answers to a client that asks and does not read, beyond those of data.
const MOST_ANSWERS: usize = 1 << 20;

/// A client's mail.
#[derive(Debug, Default)]
pub(super) struct Client {
    mail: Mutex<Mail>,
    changed: Condvar,
}

#[derive(Debug, Default)]
struct Mail {
    /// The client's number of its subscription, by topic.
    subscriptions: BTreeMap<u32, u32>,
    waiting: VecDeque<Message>,
    /// Bytes of all messages that wait.
    bytes: usize,
    /// Messages left out since the client heard of it last.
    left_out: u64,
    /// `true` while the last taken message is on its way.
    sending: bool,
    gone: bool,
}

impl Mail {
    fn push(&mut self, message: Message) {
        self.bytes += message.len();
        self.waiting.push_back(message);
    }
}

impl Client {
    fn held(&self) -> MutexGuard<'_, Mail> {
        self.mail.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Adds a message that must arrive. A client that lets too many of them wait is let go.
    pub(super) fn tell(&self, message: Message) {
        let mut mail = self.held();
        mail.push(message);
        mail.gone |= mail.bytes > MOST_WAITING + MOST_ANSWERS;
        self.changed.notify_all();
    }

    /// Subscribes to a topic under the client's own number. Returns `false` where the topic or the number has a subscription.
    pub(super) fn subscribe(&self, channel: u32, number: u32) -> bool {
        let mut mail = self.held();
        let taken = mail.subscriptions.iter();
        let is_new = taken
            .into_iter()
            .all(|(c, n)| *c != channel && *n != number);
        if is_new {
            mail.subscriptions.insert(channel, number);
        }
        is_new
    }

    /// Ends the subscription of this number, where there is one.
    pub(super) fn unsubscribe(&self, number: u32) {
        self.held().subscriptions.retain(|_, own| *own != number);
    }

    /// Ends all subscriptions: their topics are gone.
    pub(super) fn unsubscribe_all(&self) {
        self.held().subscriptions.clear();
    }

    /// Adds a message of a topic, where the client has subscribed to it. Returns `false` where it found no room.
    pub(super) fn publish(&self, channel: u32, t_ns: u64, payload: &[u8]) -> bool {
        let mut mail = self.held();
        let Some(number) = mail.subscriptions.get(&channel).copied() else {
            return true;
        };
        let fits = mail.bytes + payload.len() <= MOST_WAITING;
        match fits {
            true => mail.push(data(number, t_ns, payload)),
            false => mail.left_out += 1,
        }
        self.changed.notify_all();
        fits
    }

    /// Adds the time, if there is room: a later one says more.
    pub(super) fn show(&self, time: Message) {
        let mut mail = self.held();
        if mail.bytes + time.len() <= MOST_WAITING {
            mail.push(time);
            self.changed.notify_all();
        }
    }

    pub(super) fn is_gone(&self) -> bool {
        self.held().gone
    }

    /// Waits until everything was sent, `most` at most.
    pub(super) fn drained(&self, most: Duration) {
        let waits = |mail: &mut Mail| !mail.gone && (mail.sending || !mail.waiting.is_empty());
        drop(self.changed.wait_timeout_while(self.held(), most, waits));
    }
}

impl Mailbox for Client {
    fn take(&self) -> Option<Message> {
        let mut mail = self.held();
        loop {
            mail.sending = false;
            if mail.gone {
                return None;
            }
            if mail.waiting.is_empty() && mail.left_out > 0 {
                let left_out = std::mem::take(&mut mail.left_out);
                let told = format!("{left_out} messages were left out: they were read too slowly");
                mail.push(status(Level::Warning, &told));
            }
            if let Some(message) = mail.waiting.pop_front() {
                mail.bytes -= message.len();
                mail.sending = true;
                return Some(message);
            }
            self.changed.notify_all();
            let waited = self.changed.wait(mail);
            mail = waited.unwrap_or_else(PoisonError::into_inner);
        }
    }

    fn close(&self) {
        self.held().gone = true;
        self.changed.notify_all();
    }
}
