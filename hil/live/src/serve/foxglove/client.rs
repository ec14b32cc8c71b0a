//! Mailbox of one client: its subscriptions, and messages on their way to it. A client that reads too slowly misses data,
//! and is told how much.

use std::collections::{BTreeMap, VecDeque};

use tungstenite::Message;

use super::super::post::{Mail, Post};
use super::words::{Level, data, status};

/// Most bytes that wait for a client: some seconds of a hand.
pub(super) const MOST_WAITING: usize = 4 << 20;
/// Most bytes of answers to a client that asks and does not read, beyond those of data.
const MOST_ANSWERS: usize = 1 << 20;

/// A client's mailbox.
pub(super) type Client = Post<ClientMail>;

/// A client's mail.
#[derive(Debug, Default)]
pub(in super::super) struct ClientMail {
    /// The client's number of its subscription, by topic.
    subscriptions: BTreeMap<u32, u32>,
    waiting: VecDeque<Message>,
    /// Bytes of all messages that wait.
    bytes: usize,
    /// Messages left out since the client heard of it last.
    left_out: u64,
}

impl ClientMail {
    fn push(&mut self, message: Message) {
        self.bytes += message.len();
        self.waiting.push_back(message);
    }
}

impl Client {
    /// Adds a message that must arrive. A client that lets too many of them wait is let go.
    pub(super) fn tell(&self, message: Message) {
        let bytes = self.change(|mail| {
            mail.push(message);
            mail.bytes
        });
        self.wake();
        if bytes > MOST_WAITING + MOST_ANSWERS {
            self.close();
        }
    }

    /// Subscribes to a topic under the client's own number. Returns `false` where the topic or the number has a subscription.
    pub(super) fn subscribe(&self, channel: u32, number: u32) -> bool {
        self.change(|mail| {
            let mut taken = mail.subscriptions.iter();
            let is_new = taken.all(|(c, n)| *c != channel && *n != number);
            if is_new {
                mail.subscriptions.insert(channel, number);
            }
            is_new
        })
    }

    /// Ends the subscription of this number, where there is one.
    pub(super) fn unsubscribe(&self, number: u32) {
        self.change(|mail| mail.subscriptions.retain(|_, own| *own != number));
    }

    /// Ends all subscriptions: their topics are gone.
    pub(super) fn unsubscribe_all(&self) {
        self.change(|mail| mail.subscriptions.clear());
    }

    /// Adds a message of a topic, where the client has subscribed to it. Returns `false` where it found no room.
    pub(super) fn publish(&self, channel: u32, t_ns: u64, payload: &[u8]) -> bool {
        self.change(|mail| {
            let Some(number) = mail.subscriptions.get(&channel).copied() else {
                return true;
            };
            self.wake();
            let fits = mail.bytes + payload.len() <= MOST_WAITING;
            match fits {
                true => mail.push(data(number, t_ns, payload)),
                false => mail.left_out += 1,
            }
            fits
        })
    }

    /// Adds the time, if there is room: a later one says more.
    pub(super) fn show(&self, time: Message) {
        self.change(|mail| {
            if mail.bytes + time.len() <= MOST_WAITING {
                mail.push(time);
                self.wake();
            }
        });
    }
}

impl Mail for ClientMail {
    fn next(&mut self) -> Option<Message> {
        if self.waiting.is_empty() && self.left_out > 0 {
            let left_out = std::mem::take(&mut self.left_out);
            let told = format!("{left_out} messages were left out: they were read too slowly");
            self.push(status(Level::Warning, &told));
        }
        let message = self.waiting.pop_front()?;
        self.bytes -= message.len();
        Some(message)
    }

    fn is_owed(&self) -> bool {
        !self.waiting.is_empty()
    }
}
