//! A value that threads leave for each other.

use std::sync::{Condvar, Mutex, MutexGuard, PoisonError, TryLockError};
use std::time::Duration;

/// A value that threads leave for each other. It is whole even where a thread panicked with its lock.
#[derive(Debug, Default)]
pub(crate) struct Desk<T> {
    left: Mutex<T>,
    changed: Condvar,
}

impl<T> Desk<T> {
    /// A desk with this value.
    pub(crate) const fn new(left: T) -> Self {
        Self {
            left: Mutex::new(left),
            changed: Condvar::new(),
        }
    }

    /// Locks the value.
    pub(crate) fn left(&self) -> MutexGuard<'_, T> {
        self.left.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Changes the value, and wakes the threads that wait.
    pub(crate) fn leave(&self, leave: impl FnOnce(&mut T)) {
        leave(&mut self.left());
        self.changed.notify_all();
    }

    /// Changes the value, unless another thread has the lock; never waits.
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

    /// Waits while `is_so` holds of the value.
    pub(crate) fn wait(&self, is_so: impl Fn(&mut T) -> bool) -> MutexGuard<'_, T> {
        let waited = self.changed.wait_while(self.left(), is_so);
        waited.unwrap_or_else(PoisonError::into_inner)
    }

    /// Waits while `is_so` holds of the value, no longer than `patience`.
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
