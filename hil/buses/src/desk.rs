//! A place to leave something for a thread.

use std::sync::{Condvar, Mutex, MutexGuard, PoisonError, TryLockError};
use std::time::Duration;

/// What is left there. It is whole whatever happened to a thread that held it.
#[derive(Debug, Default)]
pub(crate) struct Desk<T> {
    left: Mutex<T>,
    changed: Condvar,
}

impl<T> Desk<T> {
    /// With this on it.
    pub(crate) const fn new(left: T) -> Self {
        Self {
            left: Mutex::new(left),
            changed: Condvar::new(),
        }
    }

    /// What lies there.
    pub(crate) fn left(&self) -> MutexGuard<'_, T> {
        self.left.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Leaves something.
    pub(crate) fn leave(&self, leave: impl FnOnce(&mut T)) {
        leave(&mut self.left());
        self.changed.notify_all();
    }

    /// The same without a wait, where another thread is at the desk.
    pub(crate) fn try_leave(&self, leave: impl FnOnce(&mut T)) {
        let mut left = match self.left.try_lock() {
            Ok(left) => left,
            Err(TryLockError::Poisoned(poisoned)) => poisoned.into_inner(),
            Err(TryLockError::WouldBlock) => return,
        };
        leave(&mut left);
        drop(left);
        self.changed.notify_all();
    }

    /// Waits while this is so.
    pub(crate) fn wait(&self, is_so: impl Fn(&mut T) -> bool) -> MutexGuard<'_, T> {
        let waited = self.changed.wait_while(self.left(), is_so);
        waited.unwrap_or_else(PoisonError::into_inner)
    }

    /// The same, no longer than `patience`.
    pub(crate) fn wait_for(
        &self,
        patience: Duration,
        is_so: impl Fn(&mut T) -> bool,
    ) -> MutexGuard<'_, T> {
        let waited = self
            .changed
            .wait_timeout_while(self.left(), patience, is_so);
        waited.unwrap_or_else(PoisonError::into_inner).0
    }
}
