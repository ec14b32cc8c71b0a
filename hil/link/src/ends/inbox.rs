//! Bounded queue of messages for the loop: a flood costs the flood and nothing else.

use std::collections::VecDeque;
use std::sync::{Condvar, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

/// Messages in the order in which they came.
#[derive(Debug)]
pub struct Inbox<T> {
    held: Mutex<(VecDeque<T>, u64)>,
    news: Condvar,
    most: usize,
}

impl<T> Inbox<T> {
    /// An inbox with room for so many.
    #[must_use]
    pub fn new(most: usize) -> Self {
        Self {
            held: Mutex::new((VecDeque::with_capacity(most), 0)),
            news: Condvar::new(),
            most,
        }
    }

    fn held(&self) -> MutexGuard<'_, (VecDeque<T>, u64)> {
        self.held.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Adds a message. One that finds no room is counted and dropped.
    pub fn push(&self, one: T) {
        let mut held = self.held();
        if held.0.len() < self.most {
            held.0.push_back(one);
            self.news.notify_one();
        } else {
            held.1 += 1;
        }
    }

    /// Waits until something comes, `at_most` so long.
    pub fn wait(&self, at_most: Duration) {
        let held = self.held();
        if held.0.is_empty() {
            // Whatever ends the wait, the loop looks for itself.
            let _ = self.news.wait_timeout(held, at_most);
        }
    }

    /// Takes the oldest message.
    pub fn take(&self) -> Option<T> {
        self.held().0.pop_front()
    }

    /// Number of messages that found no room.
    pub fn overflowed(&self) -> u64 {
        self.held().1
    }
}

#[cfg(test)]
#[path = "inbox_tests.rs"]
mod tests;
