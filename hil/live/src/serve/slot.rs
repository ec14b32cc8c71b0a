//! Mailbox of one page: messages that must arrive, and the newest picture or view. A newer one replaces one that was
//! not taken in time.

use std::collections::VecDeque;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use tungstenite::Message;

use super::server::Mailbox;

/// A page's mail.
#[derive(Debug, Default)]
pub(super) struct Slot {
    mail: Mutex<Mail>,
    changed: Condvar,
    /// The display that it looks at.
    pub(super) display: AtomicUsize,
}

#[derive(Debug, Default)]
struct Mail {
    told: VecDeque<Arc<str>>,
    picture: Option<Arc<str>>,
    /// `true` while the last taken message is on its way.
    sending: bool,
    gone: bool,
}

impl Slot {
    fn held(&self) -> MutexGuard<'_, Mail> {
        self.mail.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Adds a message that must arrive.
    pub(super) fn tell(&self, text: Arc<str>) {
        self.held().told.push_back(text);
        self.changed.notify_all();
    }

    /// Replaces the picture, if the page looks at this display.
    pub(super) fn show(&self, display: usize, picture: &Arc<str>) {
        if self.display.load(Ordering::Relaxed) == display {
            self.held().picture = Some(Arc::clone(picture));
            self.changed.notify_all();
        }
    }

    /// Drops a picture of a run that is over.
    pub(super) fn forget(&self) {
        self.held().picture = None;
    }

    /// Marks the page as gone.
    pub(super) fn close(&self) {
        self.held().gone = true;
        self.changed.notify_all();
    }

    pub(super) fn is_gone(&self) -> bool {
        self.held().gone
    }

    /// Waits for the next message; `None` once the page is gone.
    pub(super) fn next(&self) -> Option<Arc<str>> {
        let mut mail = self.held();
        loop {
            mail.sending = false;
            if mail.gone {
                return None;
            }
            if let Some(text) = mail.told.pop_front().or_else(|| mail.picture.take()) {
                mail.sending = true;
                return Some(text);
            }
            self.changed.notify_all();
            mail = self
                .changed
                .wait(mail)
                .unwrap_or_else(PoisonError::into_inner);
        }
    }

    /// Waits until everything was sent, `most` at most.
    pub(super) fn drained(&self, most: Duration) {
        let waits = |mail: &mut Mail| !mail.gone && (mail.sending || !mail.told.is_empty());
        let held = self.changed.wait_timeout_while(self.held(), most, waits);
        drop(held);
    }
}

impl Mailbox for Slot {
    fn take(&self) -> Option<Message> {
        self.next().map(|text| Message::text(&*text))
    }

    fn close(&self) {
        Self::close(self);
    }
}

#[cfg(test)]
#[path = "slot_tests.rs"]
mod tests;
