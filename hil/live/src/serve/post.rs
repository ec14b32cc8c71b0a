//! Messages on their way to a page or a client, taken by the thread that sends them.

use std::sync::{Condvar, Mutex, PoisonError};
use std::time::Duration;

use tungstenite::Message;

use crate::lock::held;

/// Messages that wait.
pub(super) trait Mail: Send + 'static {
    /// Takes the next message, where there is one.
    fn next(&mut self) -> Option<Message>;

    /// Tells whether a message waits that must arrive.
    fn is_owed(&self) -> bool;
}

/// A mailbox: mail, and how far it is sent.
#[derive(Debug, Default)]
pub(super) struct Post<M> {
    state: Mutex<State<M>>,
    changed: Condvar,
}

#[derive(Debug, Default)]
struct State<M> {
    mail: M,
    /// `true` while the last taken message is on its way.
    sending: bool,
    gone: bool,
}

impl<M: Mail> Post<M> {
    /// Looks at the mail or changes it.
    pub(super) fn change<T>(&self, change: impl FnOnce(&mut M) -> T) -> T {
        change(&mut held(&self.state).mail)
    }

    /// Wakes the thread that sends, for new mail.
    pub(super) fn wake(&self) {
        self.changed.notify_all();
    }

    /// Marks the page as gone.
    pub(super) fn close(&self) {
        held(&self.state).gone = true;
        self.wake();
    }

    pub(super) fn is_gone(&self) -> bool {
        held(&self.state).gone
    }

    /// Waits for the next message; `None` once the page is gone.
    pub(super) fn take(&self) -> Option<Message> {
        let mut state = held(&self.state);
        loop {
            state.sending = false;
            if state.gone {
                return None;
            }
            if let Some(message) = state.mail.next() {
                state.sending = true;
                return Some(message);
            }
            self.wake();
            let waited = self.changed.wait(state);
            state = waited.unwrap_or_else(PoisonError::into_inner);
        }
    }

    /// Waits until everything was sent, `most` at most.
    pub(super) fn drained(&self, most: Duration) {
        let waits = |state: &mut State<M>| !state.gone && (state.sending || state.mail.is_owed());
        let state = held(&self.state);
        drop(self.changed.wait_timeout_while(state, most, waits));
    }
}
