//! What arrived and waits for the loop: bounded, so that a flood costs the flood and nothing else.

use std::collections::VecDeque;
use std::sync::{Condvar, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

/// Things that came, in their order.
#[derive(Debug)]
pub struct Inbox<T> {
    held: Mutex<(VecDeque<T>, u64)>,
    news: Condvar,
    most: usize,
}

impl<T> Inbox<T> {
    /// With room for so many.
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

    /// Adds one. Where there is no room it is counted and goes.
    pub fn push(&self, one: T) {
        let mut held = self.held();
        if held.0.len() < self.most {
            held.0.push_back(one);
            self.news.notify_one();
        } else {
            held.1 += 1;
        }
    }

    /// Waits until something comes, or so long.
    pub fn wait(&self, at_most: Duration) {
        let held = self.held();
        if held.0.is_empty() {
            // Whatever ends the wait, the loop looks for itself.
            let _ = self.news.wait_timeout(held, at_most);
        }
    }

    /// The oldest.
    pub fn take(&self) -> Option<T> {
        self.held().0.pop_front()
    }

    /// How many found no room.
    pub fn overflowed(&self) -> u64 {
        self.held().1
    }
}

#[cfg(test)]
#[path = "inbox_tests.rs"]
mod tests;
