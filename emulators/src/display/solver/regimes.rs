//! Regimes of equal wires on one network, decomposed once for all of them.

use std::collections::VecDeque;
use std::sync::{Arc, Mutex, PoisonError};

use super::modal::{Mode, ModeKey};
use crate::display::finger::ThermalNetwork;

/// Number of regimes kept; the oldest is dropped. Plays that overlap have some ten; each current of a wire whose
/// resistance changes with temperature has its own.
pub(super) const REGIMES: usize = 96;

/// Regimes that clones of one wire share. A regime follows from network and key, so that any clone may ask first.
#[derive(Clone, Debug, Default)]
pub(super) struct Regimes(Arc<Mutex<VecDeque<Arc<Mode>>>>);

impl Regimes {
    /// The regime `key` of `network`; every call has to give the same network.
    pub(super) fn mode(&self, network: &ThermalNetwork, key: ModeKey) -> Arc<Mode> {
        // A thread that panicked with the lock held left a whole list behind.
        let mut known = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(mode) = known.iter().find(|mode| mode.key == key) {
            return Arc::clone(mode);
        }
        let mode = Arc::new(Mode::new(network, key));
        if known.len() >= REGIMES {
            known.pop_front();
        }
        known.push_back(Arc::clone(&mode));
        mode
    }
}
