//! Mailbox of one page: messages that must arrive, and the newest picture or view. A newer one replaces one that was
//! not taken in time.

use std::collections::VecDeque;
use std::sync::Arc;

use tungstenite::Message;

use super::post::{Mail, Post};

/// A page's mailbox.
pub(super) type Slot = Post<PageMail>;

/// A page's mail.
#[derive(Debug, Default)]
pub(super) struct PageMail {
    told: VecDeque<Arc<str>>,
    picture: Option<Arc<str>>,
    /// The display that it looks at.
    display: usize,
}

impl Slot {
    /// Adds a message that must arrive.
    pub(super) fn tell(&self, text: Arc<str>) {
        self.change(|mail| mail.told.push_back(text));
        self.wake();
    }

    /// Replaces the picture, if the page looks at this display.
    pub(super) fn show(&self, display: usize, picture: &Arc<str>) {
        self.change(|mail| {
            if mail.display == display {
                mail.picture = Some(Arc::clone(picture));
                self.wake();
            }
        });
    }

    /// Display that the page looks at.
    pub(super) fn display(&self) -> usize {
        self.change(|mail| mail.display)
    }

    /// Notes the display that the page looks at.
    pub(super) fn look_at(&self, display: usize) {
        self.change(|mail| mail.display = display);
    }

    /// Drops a picture of a run that is over.
    pub(super) fn forget(&self) {
        self.change(|mail| mail.picture = None);
    }
}

impl Mail for PageMail {
    fn next(&mut self) -> Option<Message> {
        let text = self.told.pop_front().or_else(|| self.picture.take());
        text.map(|text| Message::text(&*text))
    }

    fn is_owed(&self) -> bool {
        !self.told.is_empty()
    }
}

#[cfg(test)]
#[path = "slot_tests.rs"]
mod tests;
